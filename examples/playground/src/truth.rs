//! Ray-traced visibility that refines on threads of its own.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, OnceLock};

use antumbra::prelude::*;
use antumbra::reference::{
    HitImage, LightShape, LightSource, RayScene, VisibilityImage, primary_hits, soft_visibility,
};
use bevy_transform::prelude::GlobalTransform;
use glam::UVec2;

use crate::given::GivenPicture;

/// Samples on an area light of the first pass and of all others.
const PASS: [u32; 2] = [4, 16];

/// Samples on an area light after which it is not refined further.
const DEFAULT_SAMPLES: u32 = 256;

/// What is seen, by which truth is known to be that of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Size of the picture, pixels.
    pub size: UVec2,
    /// The camera.
    pub camera: Camera,
    /// Place of the camera.
    pub world_from_camera: GlobalTransform,
    /// The lights; `None` for a light that cannot shine.
    pub lights: Vec<Option<LightSource>>,
    /// Changes with the scene and its pose.
    pub scene: u64,
}

/// Visibility of the lights, as far as it is refined.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Samples on each area light.
    pub samples: u32,
    /// Visibility of each light.
    pub lights: Vec<Option<Arc<VisibilityImage>>>,
    /// The same as textures.
    pub pictures: Vec<Option<Arc<GivenPicture>>>,
}

struct Job {
    number: u64,
    scene: Arc<RayScene>,
    question: Question,
    samples: u32,
}

/// The truth of what is seen now.
pub struct Truth {
    /// Samples on an area light after which it is not refined further.
    pub limit: u32,
    asked: Option<Question>,
    answer: Option<Answer>,
    failure: Option<String>,
    jobs: Option<Sender<Job>>,
    answers: Receiver<(u64, Result<Answer, String>)>,
    current: Arc<AtomicU64>,
}

impl std::fmt::Debug for Truth {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Truth")
            .field("limit", &self.limit)
            .field("asked", &self.asked)
            .finish_non_exhaustive()
    }
}

/// The threads that trace: all but one, which draws.
fn pool() -> Option<&'static rayon::ThreadPool> {
    static POOL: OnceLock<Option<rayon::ThreadPool>> = OnceLock::new();
    let pool = POOL.get_or_init(|| {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = cores.saturating_sub(1).max(1);
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()
    });
    pool.as_ref()
}

impl Default for Truth {
    fn default() -> Self {
        let (jobs, to_do) = channel::<Job>();
        let (done, answers) = channel();
        let current = Arc::new(AtomicU64::new(0));
        let newest = current.clone();
        let thread = std::thread::Builder::new().name("truth".to_owned());
        let started = thread.spawn(move || {
            for job in to_do {
                if job.number != newest.load(Ordering::Acquire) {
                    continue;
                }
                let work = || trace(&job, &newest, &done);
                match pool() {
                    Some(pool) => pool.install(work),
                    None => work(),
                }
            }
        });
        let failure = started.as_ref().err().map(|error| format!("truth: {error}"));
        Self {
            limit: DEFAULT_SAMPLES,
            asked: None,
            answer: None,
            failure,
            jobs: started.is_ok().then_some(jobs),
            answers,
            current,
        }
    }
}

impl Drop for Truth {
    fn drop(&mut self) {
        self.stop();
    }
}

impl Truth {
    /// Asks for the truth of what is seen. The same question goes on refining its answer.
    pub fn ask(&mut self, question: Question, scene: &Arc<RayScene>) {
        if self.asked.as_ref() == Some(&question) {
            return;
        }
        self.stop();
        if let Some(jobs) = &self.jobs {
            // A thread that has ended has reported why.
            let _ = jobs.send(Job {
                number: self.current.load(Ordering::Acquire),
                scene: scene.clone(),
                question: question.clone(),
                samples: self.limit,
            });
        }
        self.asked = Some(question);
    }

    /// Stops refining and forgets the answer.
    pub fn stop(&mut self) {
        self.current.fetch_add(1, Ordering::AcqRel);
        self.asked = None;
        self.answer = None;
        self.failure = None;
    }

    /// Takes the newest answer over. Returns whether there was a new one.
    pub fn poll(&mut self) -> bool {
        let mut is_new = false;
        let current = self.current.load(Ordering::Acquire);
        for (number, answer) in self.answers.try_iter() {
            if number != current {
                continue;
            }
            is_new = true;
            match answer {
                Ok(answer) => self.answer = Some(answer),
                Err(failure) => self.failure = Some(failure),
            }
        }
        is_new
    }

    /// The newest answer.
    pub fn answer(&self) -> Option<&Answer> {
        self.answer.as_ref()
    }

    /// Why there is no answer.
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    /// Whether the answer is still refined.
    pub fn is_refining(&self) -> bool {
        let samples = self.answer.as_ref().map_or(0, |answer| answer.samples);
        self.asked.is_some() && self.failure.is_none() && samples < self.limit
    }
}

/// Refines until all samples are taken or another question is asked.
fn trace(job: &Job, newest: &AtomicU64, done: &Sender<(u64, Result<Answer, String>)>) {
    let is_old = || newest.load(Ordering::Acquire) != job.number;
    let question = &job.question;
    let (camera, place) = (&question.camera, &question.world_from_camera);
    let hits = match primary_hits(&job.scene, camera, place, question.size) {
        Ok(hits) => hits,
        Err(error) => {
            let _ = done.send((job.number, Err(format!("truth: {error}"))));
            return;
        }
    };
    let mut sums: Vec<Option<Sum>> = question.lights.iter().map(|light| light.map(Sum::new)).collect();
    let mut samples = 0;
    for pass in 0_u64.. {
        let more = PASS[usize::from(pass > 0)].min(job.samples - samples).max(1);
        for sum in sums.iter_mut().flatten() {
            if is_old() {
                return;
            }
            sum.add(&job.scene, &hits, more, pass);
        }
        samples += more;
        let is_exact = sums.iter().flatten().all(|sum| sum.is_exact);
        if is_exact {
            samples = job.samples;
        }
        let lights: Vec<_> = sums.iter().map(|sum| sum.as_ref().and_then(Sum::mean)).collect();
        let pictures = lights.iter().map(|light| light.as_deref().map(picture)).collect();
        let answer = Answer {
            samples,
            lights,
            pictures,
        };
        if done.send((job.number, Ok(answer))).is_err() || samples >= job.samples {
            return;
        }
    }
}

/// Sum of the visibilities of the passes of one light.
struct Sum {
    source: LightSource,
    is_exact: bool,
    weight: f32,
    values: Vec<f32>,
    size: UVec2,
}

impl Sum {
    fn new(source: LightSource) -> Self {
        let has_extent = match source.shape {
            LightShape::Point { .. } | LightShape::Spot { .. } | LightShape::Directional { .. } => false,
            LightShape::Rect { .. } | LightShape::Sphere { .. } => true,
        };
        Self {
            source,
            is_exact: !has_extent,
            weight: 0.0,
            values: Vec::new(),
            size: UVec2::ZERO,
        }
    }

    fn add(&mut self, scene: &RayScene, hits: &HitImage, samples: u32, pass: u64) {
        if self.is_exact && self.weight > 0.0 {
            return;
        }
        let image = soft_visibility(scene, hits, &self.source, samples, pass);
        self.size = image.size();
        self.values.resize(image.values().len(), 0.0);
        let weight = samples as f32;
        for (sum, value) in self.values.iter_mut().zip(image.values()) {
            *sum += weight * value; // NaN stays: the pixel does not count
        }
        self.weight += weight;
    }

    fn mean(&self) -> Option<Arc<VisibilityImage>> {
        let values = self.values.iter().map(|sum| sum / self.weight).collect();
        VisibilityImage::new(self.size, values).ok().map(Arc::new)
    }
}

/// Returns the visibility as texels. Pixels that do not count are lit: the light pass leaves them dark by itself.
fn picture(image: &VisibilityImage) -> Arc<GivenPicture> {
    let texels = image.values().iter().flat_map(|&value| {
        let value = if value.is_nan() { 1.0 } else { value };
        let half = half::f16::from_f32(value.clamp(0.0, 1.0)).to_le_bytes();
        [half[0], half[1]].repeat(4)
    });
    Arc::new(GivenPicture {
        size: image.size(),
        texels: texels.collect(),
    })
}
