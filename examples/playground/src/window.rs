//! The window: it passes input on, and shows what is drawn.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use antumbra::prelude::*;
use antumbra::render::RenderError;
use antumbra::techniques::Techniques;
use antumbra_playground::app::App;
use antumbra_playground::ui::theme;
use antumbra_stage::stage::one_line;
use egui::ViewportId;
use glam::UVec2;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

/// Opens the window and shows the file, until the window is closed.
///
/// # Errors
/// One line that says what is missing, such as a display or a driver.
pub fn open(file: Option<&Path>, out: &Path, size: UVec2) -> Result<(), String> {
    let events = EventLoop::new().map_err(|error| {
        format!(
            "no window can be opened ({error}); set DISPLAY, or run a script with --script FILE --out DIR"
        )
    })?;
    let mut shell = Shell {
        file: file.map(Path::to_owned),
        out: out.to_owned(),
        size,
        running: None,
        failure: None,
    };
    events
        .run_app(&mut shell)
        .map_err(|error| format!("the window has failed: {error}"))?;
    shell.failure.map_or(Ok(()), Err)
}

struct Shell {
    file: Option<PathBuf>,
    out: PathBuf,
    size: UVec2,
    running: Option<Running>,
    failure: Option<String>,
}

struct Running {
    window: Arc<Window>,
    instance: wgpu::Instance,
    /// `None` only while a new one replaces it.
    surface: Option<wgpu::Surface<'static>>,
    config: wgpu::SurfaceConfiguration,
    app: App,
    context: egui::Context,
    input: egui_winit::State,
    last: Instant,
    /// Whether the window is minimised or wholly covered. Nothing is drawn then.
    hidden: bool,
}

impl ApplicationHandler for Shell {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.running.is_some() {
            return;
        }
        match Running::start(events, self.size, &self.out) {
            Ok(mut running) => {
                if let Some(file) = &self.file {
                    running.app.open(file);
                }
                running.window.request_redraw();
                self.running = Some(running);
            }
            Err(failure) => self.fail(events, failure),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(running) = &mut self.running else { return };
        let response = running.input.on_window_event(&running.window, &event);
        // egui asks for a frame after each frame too, which would never end.
        if response.repaint && event != WindowEvent::RedrawRequested {
            running.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => events.exit(),
            WindowEvent::Resized(size) => {
                if let Err(failure) = running.resize(size) {
                    self.fail(events, failure);
                }
            }
            WindowEvent::Occluded(hidden) => {
                running.hidden = hidden;
                running.window.request_redraw();
            }
            WindowEvent::RedrawRequested if running.hidden => {}
            WindowEvent::RedrawRequested => match running.paint() {
                Ok(wait) => running.repaint_after(events, wait),
                Err(failure) => self.fail(events, failure),
            },
            _ => {}
        }
    }

    fn new_events(&mut self, events: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(running)) = (cause, &self.running) {
            // A time that has passed would wake the loop again at once, whether or not anything is drawn.
            events.set_control_flow(ControlFlow::Wait);
            running.window.request_redraw();
        }
    }
}

impl Shell {
    fn fail(&mut self, events: &ActiveEventLoop, failure: String) {
        self.failure = Some(failure);
        events.exit();
    }
}

/// Makes the surface of a window.
fn new_surface(instance: &wgpu::Instance, window: &Arc<Window>) -> Result<wgpu::Surface<'static>, String> {
    instance
        .create_surface(window.clone())
        .map_err(|error| format!("nothing can be drawn on this window: {error}"))
}

/// Makes a device that can draw on a surface.
fn device(
    instance: &wgpu::Instance,
    surface: &wgpu::Surface,
) -> Result<(wgpu::Adapter, RenderContext), String> {
    let requested = RequestedFeatures {
        timestamps: true,
        ..Default::default()
    };
    let made = pollster::block_on(async {
        let adapter = RenderContext::adapter_for(instance, Some(surface)).await?;
        let context = RenderContext::on_adapter(&adapter, requested).await?;
        Ok((adapter, context))
    });
    made.map_err(|error: RenderError| one_line(&error))
}

impl Running {
    fn start(events: &ActiveEventLoop, size: UVec2, out: &Path) -> Result<Self, String> {
        let attributes = Window::default_attributes()
            .with_title("antumbra playground")
            .with_inner_size(PhysicalSize::new(size.x, size.y));
        let window = events
            .create_window(attributes)
            .map_err(|error| format!("no window can be opened: {error}"))?;
        let window = Arc::new(window);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let surface = new_surface(&instance, &window)?;
        let (adapter, render) = device(&instance, &surface)?;
        let inner = window.inner_size();
        let mut config = surface
            .get_default_config(&adapter, inner.width.max(1), inner.height.max(1))
            .ok_or_else(|| format!("{} cannot draw on this window", render.adapter))?;
        // egui blends encoded colours.
        let formats = surface.get_capabilities(&adapter).formats;
        let plain = formats.into_iter().find(|format| !format.is_srgb());
        config.format = plain.unwrap_or(config.format);
        config.present_mode = wgpu::PresentMode::AutoVsync;
        surface.configure(&render.device, &config);
        let largest = render.device.limits().max_texture_dimension_2d as usize;
        let app = App::new(render, config.format, Techniques::default(), out.to_owned())?;
        let (context, input) = interface(&window, largest);
        Ok(Self {
            window,
            instance,
            surface: Some(surface),
            config,
            app,
            context,
            input,
            last: Instant::now(),
            hidden: false,
        })
    }

    fn resize(&mut self, size: PhysicalSize<u32>) -> Result<(), String> {
        self.hidden = size.width == 0 || size.height == 0; // minimised
        if self.hidden {
            return Ok(());
        }
        let largest = self.app.gpu.context.device.limits().max_texture_dimension_2d;
        self.config.width = size.width.min(largest);
        self.config.height = size.height.min(largest);
        let configured = self.configure();
        self.window.request_redraw();
        configured
    }

    /// Makes a new surface of the window. The old one is dropped first: a window has one at a time.
    fn renew_surface(&mut self) -> Result<(), String> {
        self.surface = None;
        self.surface = Some(new_surface(&self.instance, &self.window)?);
        Ok(())
    }

    /// Fits the surface to the window.
    ///
    /// # Errors
    /// One line that says what the window refuses, such as that it is there no more.
    fn configure(&self) -> Result<(), String> {
        let Some(surface) = &self.surface else {
            return Ok(());
        };
        let device = &self.app.gpu.context.device;
        // Without a scope, an error of the surface would end the program with a backtrace.
        let errors = device.push_error_scope(wgpu::ErrorFilter::Validation);
        surface.configure(device, &self.config);
        let error = pollster::block_on(errors.pop());
        error.map_or(Ok(()), |error| {
            Err(format!(
                "nothing can be drawn on this window any more: {}",
                one_line(&error)
            ))
        })
    }

    /// Makes everything anew on another device. The document stays.
    fn revive(&mut self) -> Result<(), String> {
        self.renew_surface()?;
        let Some(surface) = &self.surface else {
            return Ok(());
        };
        let (_, render) = device(&self.instance, surface)?;
        let largest = render.device.limits().max_texture_dimension_2d as usize;
        self.app.revive(render, self.config.format)?;
        self.configure()?;
        (self.context, self.input) = interface(&self.window, largest);
        Ok(())
    }

    /// Returns the texture that is shown next, and whether the surface should be configured anew after it is shown.
    /// Without a texture, the time is that until the next try; `None` waits for an event.
    fn next_texture(&mut self) -> Result<NextTexture, String> {
        let Some(surface) = &self.surface else {
            return Ok(NextTexture::None(None));
        };
        Ok(match surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture) => NextTexture::Some(texture, false),
            // A surface must not be configured while a texture of it is held.
            wgpu::CurrentSurfaceTexture::Suboptimal(texture) => NextTexture::Some(texture, true),
            wgpu::CurrentSurfaceTexture::Outdated => {
                self.configure()?;
                NextTexture::None(Some(Duration::ZERO))
            }
            wgpu::CurrentSurfaceTexture::Lost => {
                self.renew_surface()?;
                self.configure()?;
                NextTexture::None(Some(Duration::ZERO))
            }
            wgpu::CurrentSurfaceTexture::Timeout | wgpu::CurrentSurfaceTexture::Validation => {
                NextTexture::None(Some(RETRY))
            }
            wgpu::CurrentSurfaceTexture::Occluded => NextTexture::None(Some(HIDDEN)),
        })
    }

    /// Draws the window. Returns the time until it must be drawn again; `None` waits for an event.
    fn paint(&mut self) -> Result<Option<Duration>, String> {
        if self.app.gpu.context.notice_loss() {
            self.revive()?;
        }
        let now = Instant::now();
        let seconds = now.duration_since(self.last).as_secs_f32().min(0.1);
        self.last = now;
        self.app.advance(seconds);
        let (texture, is_suboptimal) = match self.next_texture()? {
            NextTexture::Some(texture, is_suboptimal) => (texture, is_suboptimal),
            NextTexture::None(wait) => return Ok(wait),
        };
        let input = self.input.take_egui_input(&self.window);
        let app = &mut self.app;
        let output = self.context.run_ui(input, |ui| app.ui(ui));
        self.input
            .handle_platform_output(&self.window, output.platform_output);
        let primitives = self.context.tessellate(output.shapes, output.pixels_per_point);
        let view = texture.texture.create_view(&Default::default());
        self.app.painter.paint(
            &view,
            UVec2::new(self.config.width, self.config.height),
            output.pixels_per_point,
            &primitives,
            &output.textures_delta,
        );
        self.window.pre_present_notify();
        texture.present();
        if is_suboptimal {
            self.configure()?;
        }
        let viewport = output.viewport_output.get(&ViewportId::ROOT);
        Ok(viewport.map(|viewport| viewport.repaint_delay))
    }

    fn repaint_after(&self, events: &ActiveEventLoop, wait: Option<Duration>) {
        let then = wait.and_then(|wait| Instant::now().checked_add(wait));
        match then {
            Some(_) if wait == Some(Duration::ZERO) => {
                events.set_control_flow(ControlFlow::Wait);
                self.window.request_redraw();
            }
            Some(then) => events.set_control_flow(ControlFlow::WaitUntil(then)),
            None => events.set_control_flow(ControlFlow::Wait),
        }
    }
}

/// Time until a surface that is busy is tried again.
const RETRY: Duration = Duration::from_millis(50);

/// Time until a covered window is tried again: not every system says when it is uncovered.
const HIDDEN: Duration = Duration::from_millis(500);

/// Result of asking a surface for its next texture.
enum NextTexture {
    /// A texture, and whether the surface no longer fits the window.
    Some(wgpu::SurfaceTexture, bool),
    /// None, and the time until the next try.
    None(Option<Duration>),
}

fn interface(window: &Window, largest: usize) -> (egui::Context, egui_winit::State) {
    let context = egui::Context::default();
    theme::apply(&context);
    let scale = Some(window.scale_factor() as f32);
    let state = egui_winit::State::new(
        context.clone(),
        ViewportId::ROOT,
        window,
        scale,
        window.theme(),
        Some(largest),
    );
    (context, state)
}
