//! Ray-traced visibility that refines on threads of its own.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

use antumbra::prelude::*;
use antumbra::reference::{
    HitImage, LightShape, LightSource, RayScene, VisibilityImage, primary_hits, soft_visibility,
};
use antumbra_stage::given::GivenPicture;
use bevy_transform::prelude::GlobalTransform;
use glam::UVec2;

/// Samples on an area light of the first pass and of all others.
const PASS: [u32; 2] = [4, 16];

/// Samples on an area light after which it is not refined further.
const DEFAULT_SAMPLES: u32 = 256;

/// Everything on which the truth depends. An answer belongs to the picture as long as its question is the same.
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

/// The newest answer to a job, by the job's number. A newer answer replaces one that was not taken.
type Slot = Arc<Mutex<Option<(u64, Result<Answer, String>)>>>;

/// The truth of what is seen now.
pub struct Truth {
    /// Samples on an area light after which it is not refined further.
    pub limit: u32,
    asked: Option<Question>,
    answer: Option<Answer>,
    failure: Option<String>,
    /// Where jobs are sent to; `None` while no thread runs.
    jobs: Option<Sender<Job>>,
    slot: Slot,
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

impl Default for Truth {
    fn default() -> Self {
        Self {
            limit: DEFAULT_SAMPLES,
            asked: None,
            answer: None,
            failure: None,
            jobs: None,
            slot: Slot::default(),
            current: Arc::default(),
        }
    }
}

impl Drop for Truth {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Starts the threads that trace: all but one, which draws. They end when nobody can send jobs any more.
fn start(newest: Arc<AtomicU64>, slot: Slot) -> Result<Sender<Job>, String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = cores.saturating_sub(1).max(1);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|index| format!("truth {index}"))
        .build()
        .map_err(|error| format!("truth: {error}"))?;
    let (jobs, to_do) = channel::<Job>();
    let thread = std::thread::Builder::new().name("truth".to_owned());
    let work = move || {
        for job in to_do {
            if job.number == newest.load(Ordering::Acquire) {
                pool.install(|| trace(&job, &newest, &slot));
            }
        }
    };
    thread.spawn(work).map_err(|error| format!("truth: {error}"))?;
    Ok(jobs)
}

impl Truth {
    /// Asks for the truth of what is seen. The same question goes on refining its answer.
    pub fn ask(&mut self, question: Question, scene: &Arc<RayScene>) {
        if self.asked.as_ref() == Some(&question) {
            return;
        }
        self.forget();
        if self.jobs.is_none() {
            match start(self.current.clone(), self.slot.clone()) {
                Ok(jobs) => self.jobs = Some(jobs),
                Err(failure) => self.failure = Some(failure),
            }
        }
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

    /// Forgets the answer, so that the next question begins anew.
    pub fn forget(&mut self) {
        self.current.fetch_add(1, Ordering::AcqRel);
        self.asked = None;
        self.answer = None;
        self.failure = None;
        *self.slot.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Forgets the answer and ends the threads, until a question is asked again.
    pub fn stop(&mut self) {
        if self.jobs.take().is_some() || self.asked.is_some() {
            self.forget();
        }
    }

    /// Whether threads are there to trace.
    pub fn is_running(&self) -> bool {
        self.jobs.is_some()
    }

    /// Takes the newest answer over. Returns whether there was a new one.
    pub fn poll(&mut self) -> bool {
        let new = self.slot.lock().unwrap_or_else(PoisonError::into_inner).take();
        let current = self.current.load(Ordering::Acquire);
        match new.filter(|(number, _)| *number == current) {
            Some((_, Ok(answer))) => self.answer = Some(answer),
            Some((_, Err(failure))) => self.failure = Some(failure),
            None => return false,
        }
        true
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
fn trace(job: &Job, newest: &AtomicU64, slot: &Slot) {
    let tell = |answer: Result<Answer, String>| {
        *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some((job.number, answer));
    };
    let is_old = || newest.load(Ordering::Acquire) != job.number;
    let question = &job.question;
    let (camera, place) = (&question.camera, &question.world_from_camera);
    let hits = match primary_hits(&job.scene, camera, place, question.size) {
        Ok(hits) => hits,
        Err(error) => {
            tell(Err(format!("truth: {error}")));
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
        let pictures = lights
            .iter()
            .map(|light| light.as_deref().map(GivenPicture::of).map(Arc::new))
            .collect();
        let answer = Answer {
            samples,
            lights,
            pictures,
        };
        tell(Ok(answer));
        if samples >= job.samples {
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

#[cfg(test)]
mod tests {
    use bevy_ecs::prelude::World;

    use super::*;

    fn question(size: UVec2) -> Question {
        Question {
            size,
            camera: Camera::default(),
            world_from_camera: GlobalTransform::IDENTITY,
            lights: Vec::new(),
            scene: 0,
        }
    }

    /// Threads of this process that trace.
    #[cfg(target_os = "linux")]
    fn threads() -> usize {
        let tasks = std::fs::read_dir("/proc/self/task").unwrap().flatten();
        let names = tasks.filter_map(|task| std::fs::read_to_string(task.path().join("comm")).ok());
        names
            .filter(|name| name.trim_end() == "truth" || name.starts_with("truth "))
            .count()
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn threads_run_only_while_a_question_is_asked() {
        let wait = |is_done: &mut dyn FnMut() -> bool| {
            let start = std::time::Instant::now();
            while !is_done() {
                assert!(start.elapsed().as_secs() < 20);
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        };
        let scene = Arc::new(RayScene::from_world(&mut World::new()));
        let mut truth = Truth::default();
        assert_eq!((truth.is_running(), threads()), (false, 0));
        truth.ask(question(UVec2::new(4, 2)), &scene);
        assert!(truth.is_running() && truth.is_refining());
        wait(&mut || truth.poll());
        assert!(threads() > 0);
        assert!(!truth.is_refining(), "{:?}", truth.failure());
        truth.stop();
        assert!(truth.answer().is_none());
        wait(&mut || threads() == 0);
        truth.ask(question(UVec2::new(2, 2)), &scene);
        wait(&mut || truth.poll());
    }
}
