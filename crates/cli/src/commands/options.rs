//! Options that several commands share: the camera, the light, the format of rays, the grid, and
//! the folder of charts.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use intertri::Threshold;
use intertri::fixed::Bits;
use intertri_scene::{
    Camera, CameraError, Coordinate, Light, Mesh, RaysFormat, Scene, SceneGeometry,
};

use crate::engine::name::EngineName;
use crate::error::{Error, Result};
use crate::io::numbers;

/// The camera options. If none of them is given, the camera frames the whole model, and the
/// built-in scene uses its own camera.
#[derive(Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraOptions {
    /// The position of the camera
    #[arg(long, value_name = "X,Y,Z", value_parser = WrittenPoint::read, allow_hyphen_values = true)]
    eye: Option<WrittenPoint>,

    /// The point at the centre of the picture [default: the centre of the model]
    #[arg(long, value_name = "X,Y,Z", value_parser = WrittenPoint::read, allow_hyphen_values = true, requires = "eye")]
    target: Option<WrittenPoint>,

    /// The direction from which to frame the whole model, instead of --eye [default: 0.55,0.38,1,
    /// rotated with --up]
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::point::<f32>, allow_hyphen_values = true, conflicts_with = "eye")]
    view: Option<[f32; 3]>,

    /// The direction that points up, such as 0,0,1 for a model whose z axis points up [default:
    /// 0,1,0 or, if you look straight along it, 0,0,-1 from above and 0,0,1 from below]
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::point::<f32>, allow_hyphen_values = true)]
    up: Option<[f32; 3]>,

    /// The vertical field of view in degrees [default: 35]
    #[arg(long, value_name = "DEGREES", value_parser = fov, allow_hyphen_values = true)]
    fov: Option<f64>,
}

impl CameraOptions {
    /// Returns the scene to draw: `model`, or the built-in scene if there is no model.
    pub(crate) fn scene(&self, model: Option<Mesh>, aspect: f64) -> Result<Scene> {
        self.scene_or(model, Scene::built_in, aspect)
    }

    /// Returns the scene to draw: `model`, or the scene that `other` creates if there is no model.
    pub(crate) fn scene_or<S: Coordinate>(
        &self,
        model: Option<Mesh<S>>,
        other: impl FnOnce() -> Scene<S>,
        aspect: f64,
    ) -> Result<Scene<S>> {
        if let Some(mesh) = model {
            return self.scene_of(mesh, aspect);
        }
        let mut scene = other();
        let Self { eye, target, view, up, fov } = self;
        let own = eye.or(*target).is_none() && view.or(*up).is_none() && fov.is_none();
        if !own {
            scene.camera = self.camera(&scene.mesh, aspect)?;
        }
        Ok(scene)
    }

    /// Returns a scene of `model`, seen by the camera that these options describe.
    pub(crate) fn scene_of<S: Coordinate, M: SceneGeometry<S>>(
        &self,
        model: M,
        aspect: f64,
    ) -> Result<Scene<S, M>> {
        let camera = self.camera(&model, aspect)?;
        Ok(Scene::seen_by(model, camera))
    }

    /// Creates the camera for a scene that shows `mesh`.
    fn camera<S: Coordinate>(
        &self,
        mesh: &impl SceneGeometry<S>,
        aspect: f64,
    ) -> Result<Camera<S>> {
        let fov = self.fov.unwrap_or(Camera::FOV);
        let camera = if let Some(eye) = self.eye.map(WrittenPoint::of::<S>) {
            let middle = mesh.bounding_box().map_or([S::ZERO; 3], |bounds| {
                // Halve the coordinates before adding them, so that the sum of two large
                // coordinates does not overflow.
                let [min, max]: [[f64; 3]; 2] = [bounds.min, bounds.max].map(|p| p.map(Into::into));
                [0, 1, 2].map(|axis| S::nearest(min[axis] * 0.5 + max[axis] * 0.5))
            });
            let target = self.target.map_or(middle, WrittenPoint::of::<S>);
            let view = [0, 1, 2].map(|k| (eye[k].into() - target[k].into()) as f32);
            let up = self.up.unwrap_or_else(|| Camera::up_for(view));
            Camera::new(eye, target, up, fov)
        } else {
            let view = self.view.unwrap_or_else(|| Camera::view_for(self.up.unwrap_or(Camera::UP)));
            let up = self.up.unwrap_or_else(|| Camera::up_for(view));
            Camera::framing_from(mesh.enclosing_points(), view, up, fov, aspect)
        };
        camera.map_err(|error| match error {
            CameraError::Up => Error::new(
                "camera: --up is zero or along the line of sight; give another direction",
            ),
            error => error.into(),
        })
    }

    /// Returns the up direction that the camera has with these options, and whether the user set
    /// it.
    pub(crate) fn up<S: Coordinate>(&self, camera: &Camera<S>) -> ([f32; 3], bool) {
        let [_, _, forward] = camera.axes();
        let up = self.up.unwrap_or_else(|| Camera::up_for(forward.map(|x| -x as f32)));
        (up, self.up.is_some())
    }
}

/// Parses a field of view in degrees.
fn fov(text: &str) -> std::result::Result<f64, String> {
    match text.parse() {
        Ok(fov) if 0.0 < fov && fov < 180.0 => Ok(fov),
        _ => Err("give a number of degrees between 0 and 180".to_owned()),
    }
}

/// A point as the user wrote it. It is rounded once, to f32 or to f64, as soon as the scene's
/// scalar is known.
#[derive(Clone, Copy)]
pub(crate) struct WrittenPoint {
    single: [f32; 3],
    double: [f64; 3],
}

impl WrittenPoint {
    fn read(text: &str) -> std::result::Result<Self, String> {
        Ok(Self { single: numbers::point(text)?, double: numbers::point(text)? })
    }

    fn of<S: Coordinate>(self) -> [S; 3] {
        if S::NAME == f32::NAME { self.single.map(S::from) } else { self.double.map(S::nearest) }
    }
}

/// The light options. If none of them is given, the light is above the camera's left shoulder, or
/// at a fixed position in the built-in scene.
#[derive(Args)]
#[command(next_help_heading = "Light")]
pub(crate) struct LightOptions {
    /// The position of the light [default: above the camera's left shoulder]
    #[arg(long, value_name = "X,Y,Z", value_parser = finite_place, allow_hyphen_values = true, conflicts_with = "sun")]
    light: Option<WrittenPoint>,

    /// The direction toward a light that is so far away that its rays are parallel
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    sun: Option<[f32; 3]>,
}

impl LightOptions {
    /// Sets the light of a scene, if the user chose one.
    pub(crate) fn shine_on<S: Coordinate, M: SceneGeometry<S>>(
        &self,
        scene: &mut Scene<S, M>,
    ) -> Result<()> {
        if let Some(position) = self.light {
            scene.light = Light::Point { position: position.of() };
        }
        if let Some(toward) = self.sun {
            let bounds = scene.mesh.bounding_box();
            let sun = bounds.and_then(|bounds| Light::sun(toward, &bounds));
            scene.light =
                sun.ok_or_else(|| Error::new("--sun: the model is too large; scale it down"))?;
        }
        Ok(())
    }
}

/// Parses a point with finite coordinates.
fn finite_place(text: &str) -> std::result::Result<WrittenPoint, String> {
    finite(text)?;
    WrittenPoint::read(text)
}

/// Parses three finite numbers.
fn finite(text: &str) -> std::result::Result<[f32; 3], String> {
    let numbers: [f32; 3] = numbers::point(text)?;
    if numbers.iter().all(|x| x.is_finite()) {
        Ok(numbers)
    } else {
        Err("give finite numbers".into())
    }
}

/// Parses three finite numbers that are not all zero.
fn direction(text: &str) -> std::result::Result<[f32; 3], String> {
    let numbers = finite(text)?;
    if numbers == [0.0; 3] { Err("give a direction that is not zero".into()) } else { Ok(numbers) }
}

/// Returns the threshold for an engine: `given` or the default if the engine uses one, and
/// otherwise `None`. Refuses a given threshold that the engine would not use.
pub(crate) fn threshold_of(
    engine: EngineName,
    given: Option<Threshold>,
) -> Result<Option<Threshold>> {
    match given {
        _ if engine.has_threshold() => Ok(Some(given.unwrap_or_default())),
        None => Ok(None),
        Some(_) => Err(Error::usage(format!(
            "--threshold: engine {engine} has none; omit it, or choose --engine certified"
        ))),
    }
}

/// Parses the number of bits per coordinate on the grid of the `fixed` engine.
pub(crate) fn grid_bits(text: &str) -> std::result::Result<Bits, String> {
    let number = text.parse().map_err(|_| "give a whole number from 1 to 20".to_owned())?;
    Bits::of_grid(number).map_err(|error| error.to_string())
}

/// Parses two opposite corners of a box.
pub(crate) fn grid_bounds(text: &str) -> std::result::Result<[[f32; 3]; 2], String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    let numbers = numbers.and_then(|numbers| <[f32; 6]>::try_from(numbers).ok());
    let [a, b, c, d, e, f] = numbers
        .filter(|numbers| numbers.iter().all(|x| x.is_finite()))
        .ok_or("give six finite numbers separated by commas: two opposite corners of a box")?;
    Ok([[a, b, c], [d, e, f]])
}

/// Returns a parser for the formats of ray files.
pub(crate) fn rays_format() -> impl TypedValueParser<Value = RaysFormat> {
    PossibleValuesParser::new(["csv", "raw", "raw64"]).map(|name| match &*name {
        "csv" => RaysFormat::Csv,
        "raw" => RaysFormat::Raw,
        _ => RaysFormat::Raw64,
    })
}

/// The options of all commands that draw charts.
#[derive(Args)]
pub(crate) struct ChartOptions {
    /// The folder to write the files to
    #[arg(short, long, value_name = "FOLDER", default_value = "docs/charts")]
    pub(crate) output: PathBuf,

    /// Finish in less than a minute, with less precise results
    #[arg(long)]
    pub(crate) quick: bool,

    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
