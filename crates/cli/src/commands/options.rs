//! Options that several commands share: the camera, the format of rays, the grid, the folder of charts.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use intertri::fixed::Bits;
use intertri_scene::{Camera, CameraError, Mesh, RaysFormat, Scene};

use crate::io::numbers;

/// The camera. Without any of these, a model is framed as a whole and the built-in scene is seen by
/// its own camera.
#[derive(Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraOptions {
    /// Where the camera stands
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::point, allow_hyphen_values = true)]
    eye: Option<[f32; 3]>,

    /// What is in the middle of the picture [default: the middle of the model]
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::point, allow_hyphen_values = true, requires = "eye")]
    target: Option<[f32; 3]>,

    /// From which direction to frame the whole model, instead of --eye [default: 0.55,0.38,1]
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::point, allow_hyphen_values = true, conflicts_with = "eye")]
    view: Option<[f32; 3]>,

    /// What is up [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::point, allow_hyphen_values = true)]
    up: Option<[f32; 3]>,

    /// The vertical field of view in degrees [default: 35]
    #[arg(long, value_name = "DEGREES", value_parser = fov, allow_hyphen_values = true)]
    fov: Option<f64>,
}

impl CameraOptions {
    /// The scene to draw: `model`, or the built-in scene.
    pub(crate) fn scene(&self, model: Option<Mesh>, aspect: f64) -> Result<Scene, CameraError> {
        if let Some(mesh) = model {
            let camera = self.camera(&mesh, aspect)?;
            return Ok(Scene::seen_by(mesh, camera));
        }
        let mut scene = Scene::built_in();
        let Self { eye, target, view, up, fov } = self;
        let own = eye.or(*target).or(*view).or(*up).is_none() && fov.is_none();
        if !own {
            scene.camera = self.camera(&scene.mesh, aspect)?;
        }
        Ok(scene)
    }

    fn camera(&self, mesh: &Mesh, aspect: f64) -> Result<Camera, CameraError> {
        let up = self.up.unwrap_or(Camera::UP);
        let fov = self.fov.unwrap_or(Camera::FOV);
        let Some(eye) = self.eye else {
            let view = self.view.unwrap_or(Camera::VIEW);
            return Camera::framing_from(mesh.points(), view, up, fov, aspect);
        };
        let middle = mesh.bounds().map_or([0.0; 3], |bounds| {
            // Halved before they are added, so that the largest f32 do not overflow.
            [0, 1, 2].map(|axis| bounds.min[axis] * 0.5 + bounds.max[axis] * 0.5)
        });
        Camera::new(eye, self.target.unwrap_or(middle), up, fov)
    }
}

/// A field of view in degrees.
fn fov(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(fov) if 0.0 < fov && fov < 180.0 => Ok(fov),
        _ => Err("give a number of degrees between 0 and 180".to_owned()),
    }
}

/// The bits of a coordinate on the grid of engine `fixed`.
pub(crate) fn grid_bits(text: &str) -> Result<Bits, String> {
    let number = text.parse().map_err(|_| "give a whole number from 1 to 20".to_owned())?;
    Bits::of_grid(number).map_err(|error| error.to_string())
}

/// Two opposite corners of a box.
pub(crate) fn grid_bounds(text: &str) -> Result<[[f32; 3]; 2], String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    let numbers = numbers.and_then(|numbers| <[f32; 6]>::try_from(numbers).ok());
    let [a, b, c, d, e, f] = numbers
        .filter(|numbers| numbers.iter().all(|x| x.is_finite()))
        .ok_or("give six finite numbers with commas between them: two opposite corners of a box")?;
    Ok([[a, b, c], [d, e, f]])
}

/// The format of a file of rays.
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
    /// The folder that gets the files
    #[arg(short, long, value_name = "FOLDER", default_value = "docs/charts")]
    pub(crate) output: PathBuf,

    /// Less than a minute, and less sharp
    #[arg(long)]
    pub(crate) quick: bool,

    /// Print a report for programs, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
