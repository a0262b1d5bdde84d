//! Engines that call Embree, version 3 or 4, through its C API. The shared library is loaded at run
//! time, so you can build this program without having Embree installed.
//!
//! Rays are stored as a structure of arrays, in groups that each hold the rays of one call. Each
//! group is copied into the structure that Embree reads and writes, and the result is copied out. A
//! renderer that fills the structure directly would do the same amount of work.

mod collector;
mod instances;

use std::ffi::{CString, c_char, c_void};
use std::mem::ManuallyDrop;
use std::ops::Range;
use std::path::PathBuf;
use std::ptr::null_mut;
use std::sync::Arc;

use intertri::Ray;
use intertri_scene::Mesh;
use rayon::prelude::*;

use crate::engine::{Answer, CHUNK, Engine, Question};
use crate::flush_to_zero::with_flush_to_zero;
pub use collector::Collector;
use collector::collect;
pub use instances::Instances;

/// An opaque pointer to a device, a scene, a geometry, or another object.
type Ptr = *mut c_void;

/// Declares Embree's functions, and looks them up in the library.
macro_rules! api {
    ($($field:ident = $name:literal: fn($($arg:ty),*) $(-> $ret:ty)?;)*) => {
        pub struct Api {
            $($field: unsafe extern "C" fn($($arg),*) $(-> $ret)?,)*
            /// The library. It is never unloaded, because threads that built a scene may still be
            /// running.
            _library: ManuallyDrop<libloading::Library>,
        }

        impl Api {
            fn load(library: libloading::Library) -> Result<Self, libloading::Error> {
                // SAFETY: the types are those in Embree's manual; the pointers live as long as the
                // library, which is stored next to them.
                unsafe {
                    Ok(Self { $($field: *library.get(concat!($name, "\0").as_bytes())?,)* _library: ManuallyDrop::new(library) })
                }
            }
        }
    };
}

api! {
    new_device = "rtcNewDevice": fn(*const c_char) -> Ptr;
    release_device = "rtcReleaseDevice": fn(Ptr);
    device_property = "rtcGetDeviceProperty": fn(Ptr, i32) -> isize;
    device_error = "rtcGetDeviceError": fn(Ptr) -> i32;
    new_scene = "rtcNewScene": fn(Ptr) -> Ptr;
    release_scene = "rtcReleaseScene": fn(Ptr);
    scene_flags = "rtcSetSceneFlags": fn(Ptr, i32);
    scene_quality = "rtcSetSceneBuildQuality": fn(Ptr, i32);
    commit_scene = "rtcCommitScene": fn(Ptr);
    new_geometry = "rtcNewGeometry": fn(Ptr, i32) -> Ptr;
    release_geometry = "rtcReleaseGeometry": fn(Ptr);
    new_buffer = "rtcSetNewGeometryBuffer": fn(Ptr, i32, u32, i32, usize, usize) -> Ptr;
    commit_geometry = "rtcCommitGeometry": fn(Ptr);
    intersect_filter = "rtcSetGeometryIntersectFilterFunction": fn(Ptr, Ptr);
    geometry_quality = "rtcSetGeometryBuildQuality": fn(Ptr, i32);
    update_buffer = "rtcUpdateGeometryBuffer": fn(Ptr, i32, u32);
    buffer_data = "rtcGetGeometryBufferData": fn(Ptr, i32, u32) -> Ptr;
    get_geometry = "rtcGetGeometry": fn(Ptr, u32) -> Ptr;
    instanced_scene = "rtcSetGeometryInstancedScene": fn(Ptr, Ptr);
    transform = "rtcSetGeometryTransform": fn(Ptr, u32, i32, *const f32);
    attach_geometry = "rtcAttachGeometry": fn(Ptr, Ptr) -> u32;
    intersect_1 = "rtcIntersect1": fn(Ptr, Ptr, Ptr);
    intersect_8 = "rtcIntersect8": fn(*const i32, Ptr, Ptr, Ptr);
    intersect_16 = "rtcIntersect16": fn(*const i32, Ptr, Ptr, Ptr);
    occluded_1 = "rtcOccluded1": fn(Ptr, Ptr, Ptr);
    occluded_8 = "rtcOccluded8": fn(*const i32, Ptr, Ptr, Ptr);
    occluded_16 = "rtcOccluded16": fn(*const i32, Ptr, Ptr, Ptr);
}

// Constants of the API. They are the same in versions 3 and 4.
const TRIANGLES: i32 = 0;
const INDEX_BUFFER: i32 = 0;
const VERTEX_BUFFER: i32 = 1;
const UINT3: i32 = 0x5003;
const FLOAT3: i32 = 0x9003;
const ROBUST: i32 = 1 << 2;
const VERSION: i32 = 0;
const MEDIUM: i32 = 1;
const HIGH: i32 = 2;
const REFIT: i32 = 3;
const DYNAMIC: i32 = 1;

impl Api {
    /// Loads the library at `path` or, if no path is given, searches the system's library path,
    /// newer versions first.
    pub fn open(path: Option<PathBuf>) -> Result<Arc<Self>, String> {
        let known = ["libembree4.so.4", "libembree4.so", "libembree3.so.3", "libembree4.dylib"];
        let paths = path.map_or_else(|| known.map(PathBuf::from).to_vec(), |path| vec![path]);
        let mut error = String::new();
        for path in paths {
            // SAFETY: loading runs the initializers of the library, which the user chose.
            match unsafe { libloading::Library::new(&path) }.and_then(Self::load) {
                Ok(api) => return Ok(Arc::new(api)),
                Err(e) => error = e.to_string(),
            }
        }
        Err(error)
    }

    /// Returns the library's name and version, such as "Embree 4.4.0".
    pub fn version(&self) -> String {
        // SAFETY: the device has the default configuration, is queried once, and is then released.
        let version = unsafe {
            let device = (self.new_device)(std::ptr::null());
            let version = (self.device_property)(device, VERSION);
            (self.release_device)(device);
            version
        };
        format!("Embree {}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
    }
}

/// The options for building a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Build {
    pub robust: bool,
    pub high: bool,
    /// Whether to limit the library to AVX2, even if the CPU supports more.
    pub avx2: bool,
    /// The number of threads for the build; 0 uses all.
    pub threads: u32,
    /// Whether to install a filter that collects every hit.
    pub collect: bool,
}

/// A mesh as an Embree scene.
pub struct Scene {
    api: Arc<Api>,
    device: Ptr,
    scene: Ptr,
    /// The version, including minor and patch numbers, such as 40400 for 4.4.0.
    pub version: isize,
}

// SAFETY: a committed scene may be queried from any thread.
unsafe impl Send for Scene {}
// SAFETY: as for `Send`.
unsafe impl Sync for Scene {}

impl Scene {
    pub fn new(api: &Arc<Api>, mesh: &Mesh, build: Build) -> Result<Self, String> {
        let scene = Self::empty(api, build)?;
        scene.add(mesh, build.collect);
        scene.checked("the mesh")
    }

    /// Creates a scene without geometries.
    fn empty(api: &Arc<Api>, build: Build) -> Result<Self, String> {
        // Without `frequency_level`, Embree would choose a narrower hierarchy on server CPUs.
        let isa = if build.avx2 { "isa=avx2," } else { "" };
        let config = format!("{isa}frequency_level=simd256,threads={}", build.threads);
        let config = CString::new(config).map_err(|e| e.to_string())?;
        // SAFETY: the calls are in the order that Embree's manual prescribes.
        unsafe {
            let device = (api.new_device)(config.as_ptr());
            if device.is_null() {
                return Err("Embree cannot create a device".into());
            }
            let scene = (api.new_scene)(device);
            (api.scene_flags)(scene, if build.robust { ROBUST } else { 0 });
            (api.scene_quality)(scene, if build.high { HIGH } else { MEDIUM });
            let version = (api.device_property)(device, VERSION);
            Ok(Self { api: api.clone(), device, scene, version })
        }
    }

    /// Adds a mesh, with the collecting filter if `collects` is set.
    fn add(&self, mesh: &Mesh, collects: bool) {
        let Self { api, device, scene, .. } = self;
        // SAFETY: the calls are in the order that Embree's manual prescribes; the buffers have the
        // sizes that are passed.
        unsafe {
            let geometry = (api.new_geometry)(*device, TRIANGLES);
            let fill = |kind, format, rows: &[[u32; 3]]| {
                let to = (api.new_buffer)(geometry, kind, 0, format, 12, rows.len());
                if !to.is_null() {
                    std::ptr::copy_nonoverlapping(rows.as_ptr(), to.cast(), rows.len());
                }
            };
            let bits: Vec<_> = mesh.positions.iter().map(|p| p.map(f32::to_bits)).collect();
            fill(VERTEX_BUFFER, FLOAT3, &bits);
            fill(INDEX_BUFFER, UINT3, &mesh.triangles);
            if collects {
                (api.intersect_filter)(geometry, collect as *const () as Ptr);
            }
            (api.commit_geometry)(geometry);
            (api.attach_geometry)(*scene, geometry);
            (api.release_geometry)(geometry);
        }
    }

    /// Returns the scene, unless the device reports an error.
    fn checked(self, what: &str) -> Result<Self, String> {
        // SAFETY: the device exists.
        match unsafe { (self.api.device_error)(self.device) } {
            0 => Ok(self),
            error => Err(format!("Embree reports error {error} for {what}")),
        }
    }

    /// Prepares the scene for refits. Call this before its vertices move.
    pub fn for_refits(self) -> Self {
        // SAFETY: the scene has exactly one geometry, and is not yet committed.
        unsafe {
            let geometry = (self.api.get_geometry)(self.scene, 0);
            (self.api.geometry_quality)(geometry, REFIT);
            (self.api.commit_geometry)(geometry);
            (self.api.scene_flags)(self.scene, DYNAMIC);
        }
        self
    }

    /// Moves all vertices, whose number must not change, and refits the hierarchy.
    pub fn refit(&self, vertices: &[[f32; 3]]) {
        // SAFETY: the buffer has one row per vertex of the mesh, and nothing queries the scene
        // meanwhile.
        unsafe {
            let geometry = (self.api.get_geometry)(self.scene, 0);
            let to = (self.api.buffer_data)(geometry, VERTEX_BUFFER, 0);
            if !to.is_null() {
                std::ptr::copy_nonoverlapping(vertices.as_ptr(), to.cast(), vertices.len());
            }
            (self.api.update_buffer)(geometry, VERTEX_BUFFER, 0);
            (self.api.commit_geometry)(geometry);
            (self.api.commit_scene)(self.scene);
        }
    }

    /// Builds the hierarchy.
    pub fn commit(&self) {
        // SAFETY: the scene is fully set up.
        unsafe { (self.api.commit_scene)(self.scene) }
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: the scene and the device are owned, and nothing queries them any more.
        unsafe {
            (self.api.release_scene)(self.scene);
            (self.api.release_device)(self.device);
        }
    }
}

/// The rays of a group: their origins, near ends, directions, and far ends.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct Group<const N: usize>([[f32; N]; 8]);

impl<const N: usize> Group<N> {
    pub fn new(rays: &[Ray]) -> Self {
        let mut group = Self([[0.0; N]; 8]);
        for (lane, r) in rays.iter().enumerate() {
            let [[a, b, c], [d, e, f]] = [r.origin, r.dir];
            for (row, x) in group.0.iter_mut().zip([a, b, c, r.t_min, d, e, f, r.t_max]) {
                row[lane] = x;
            }
        }
        group
    }
}

/// Embree's `RTCRayHit`, `RTCRayHit8` and `RTCRayHit16`, which all have this layout.
#[repr(C, align(64))]
pub struct RayHit<const N: usize> {
    origin: [[f32; N]; 3],
    near: [f32; N],
    dir: [[f32; N]; 3],
    time: [f32; N],
    far: [f32; N],
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
    normal: [[f32; N]; 3],
    uv: [[f32; N]; 2],
    triangle: [u32; N],
    geometry: [u32; N],
    /// The second element exists only in some builds of Embree.
    instance: [[u32; N]; 2],
}

impl<const N: usize> RayHit<N> {
    const NONE: Self = Self {
        origin: [[0.0; N]; 3],
        near: [0.0; N],
        dir: [[0.0; N]; 3],
        time: [0.0; N],
        far: [0.0; N],
        mask: [!0; N],
        id: [0; N],
        flags: [0; N],
        normal: [[0.0; N]; 3],
        uv: [[0.0; N]; 2],
        triangle: [!0; N],
        geometry: [!0; N],
        instance: [[!0; N]; 2],
    };
}

impl<const N: usize> RayHit<N> {
    /// Returns rays without hits, each with its lane as its ID, so that filters can tell rays
    /// apart.
    pub fn numbered() -> Self {
        Self { id: std::array::from_fn(|lane| lane as u32), ..Self::NONE }
    }
}

/// `RTCIntersectArguments` and `RTCOccludedArguments` of version 4.
#[derive(Clone, Copy)]
#[repr(C)]
struct Arguments {
    flags: u32,
    features: u32,
    pointers: [Ptr; 3],
    min_width: f32,
}

/// `RTCIntersectContext` of version 3.
#[repr(C)]
struct Context {
    flags: u32,
    filter: Ptr,
    instance: [u32; 2],
    /// The caller's field, which points to the collector of hits. In version 4, fewer fields
    /// precede this one, but none of the preceding fields is read.
    collector: Ptr,
}

/// A scene queried with N rays per call: 1, 8 or 16.
pub struct Embree<const N: usize> {
    scene: Arc<Scene>,
    question: Question,
    count: usize,
    groups: Vec<Group<N>>,
    triangles: Vec<[u32; N]>,
    t: Vec<[f32; N]>,
}

impl<const N: usize> Embree<N> {
    pub fn new(scene: Arc<Scene>) -> Self {
        let question = Question { any: false, coherent: false };
        Self { scene, question, count: 0, groups: vec![], triangles: vec![], t: vec![] }
    }

    /// Traces rays. Stores each ray's triangle and t, and the values that `keep` extracts from each
    /// group's hits.
    #[inline(always)]
    fn trace_keeping<K: Send>(
        &mut self,
        part: Range<usize>,
        kept: &mut [K],
        keep: impl Fn(&mut K, &RayHit<N>) + Sync,
    ) {
        let Self { scene, question, count, groups, triangles, t } = self;
        let last = groups.len() - 1;
        let tail = *count - last * N;
        let part = part.start / N..part.end.div_ceil(N);
        let chunks = (groups[part.clone()].par_chunks(CHUNK / N))
            .zip(triangles[part.clone()].par_chunks_mut(CHUNK / N))
            .zip(kept[part.clone()].par_chunks_mut(CHUNK / N))
            .zip(t[part.clone()].par_chunks_mut(CHUNK / N));
        chunks.enumerate().for_each(|(chunk, (((groups, triangles), kept), t))| {
            let caller = Caller::new(scene, *question);
            let mut hit = RayHit::NONE;
            with_flush_to_zero(|| {
                for (i, group) in groups.iter().enumerate() {
                    let live = if part.start + chunk * (CHUNK / N) + i == last { tail } else { N };
                    caller.ask(group, live, &mut hit);
                    t[i] = hit.far;
                    if !question.any {
                        triangles[i] = hit.triangle;
                        keep(&mut kept[i], &hit);
                    }
                }
            });
        });
    }
}

impl<const N: usize> Engine for Embree<N> {
    fn load(&mut self, rays: &[Ray], question: Question) {
        self.groups = rays.chunks(N).map(Group::new).collect();
        self.triangles = vec![[u32::MAX; N]; self.groups.len()];
        self.t = vec![[0.0; N]; self.groups.len()];
        (self.question, self.count) = (question, rays.len());
    }

    fn trace(&mut self, part: Range<usize>) {
        let mut nothing = vec![(); self.groups.len()];
        self.trace_keeping(part, &mut nothing, |(), _| ());
    }

    fn answers(&self) -> Vec<Answer> {
        let found = self.triangles.as_flattened().iter().zip(self.t.as_flattened());
        let answer = |(&triangle, &t): (&u32, &f32)| match self.question.any {
            // Embree sets the far end of an occluded ray to minus infinity.
            true if t == f32::NEG_INFINITY => Answer::ANY,
            false if triangle != u32::MAX => Answer { triangle, t: t.into() },
            _ => Answer::MISS,
        };
        found.take(self.count).map(answer).collect()
    }
}

/// A prepared call to a query function.
pub struct Caller<'a> {
    scene: &'a Scene,
    any: bool,
    arguments: Arguments,
    context: Context,
}

impl<'a> Caller<'a> {
    fn new(scene: &'a Scene, question: Question) -> Self {
        let pointers = [null_mut(); 3];
        // The flag for coherent rays is a different bit in each version.
        let flag = |bit: u32| if question.coherent { 1 << bit } else { 0 };
        Self {
            scene,
            any: question.any,
            arguments: Arguments { flags: flag(16), features: !0, pointers, min_width: 0.0 },
            context: Context {
                flags: flag(0),
                filter: null_mut(),
                instance: [!0; 2],
                collector: null_mut(),
            },
        }
    }

    /// Prepares calls that collect every hit. The collector must outlive them.
    pub fn collecting(scene: &'a Scene, collector: *mut Collector) -> Self {
        let mut caller = Self::new(scene, Question { any: false, coherent: false });
        caller.context.collector = collector.cast();
        caller
    }

    #[inline(always)]
    pub fn ask<const N: usize>(&self, group: &Group<N>, live: usize, hit: &mut RayHit<N>) {
        let [x, y, z, near, dx, dy, dz, far] = group.0;
        (hit.origin, hit.near) = ([x, y, z], near);
        (hit.dir, hit.far) = ([dx, dy, dz], far);
        (hit.triangle, hit.geometry) = ([!0; N], [!0; N]);
        let ray = (&raw mut *hit).cast();
        let api = &self.scene.api;
        let scene = self.scene.scene;
        // Both structures are passed by pointer after the scene; their order depends on the
        // version.
        let mut arguments = self.arguments;
        arguments.pointers[0] = if self.context.collector.is_null() {
            null_mut()
        } else {
            (&raw const self.context).cast_mut().cast()
        };
        let (one, two): (Ptr, Ptr) = if self.scene.version >= 40_000 {
            (ray, (&raw const arguments).cast_mut().cast())
        } else {
            ((&raw const self.context).cast_mut().cast(), ray)
        };
        // SAFETY: the structures have the layout of the library's version, and the mask has as many
        // lanes as the call needs. Embree writes to neither the context nor the arguments.
        unsafe {
            if N == 1 {
                let call = if self.any { api.occluded_1 } else { api.intersect_1 };
                call(scene, one, two);
            } else {
                #[repr(align(64))]
                struct Mask([i32; 16]);
                let mut mask = Mask([-1; 16]);
                if live < N {
                    mask.0[live..].fill(0);
                }
                let call = match (N, self.any) {
                    (8, false) => api.intersect_8,
                    (8, true) => api.occluded_8,
                    (_, false) => api.intersect_16,
                    (_, true) => api.occluded_16,
                };
                call(mask.0.as_ptr(), scene, one, two);
            }
        }
    }
}
