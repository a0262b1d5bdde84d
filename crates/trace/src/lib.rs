//! A bounding volume hierarchy over triangles whose query results equal those of a plain loop, bit
//! for bit.
//!
//! ```
//! use intertri_trace::Bvh;
//! use intertri_trace::intertri::{Ray, Triangle};
//!
//! let floor = Triangle::new([-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [0.0, 0.0, 9.0]);
//! let wall = Triangle::new([-9.0, -9.0, 5.0], [9.0, -9.0, 5.0], [0.0, 9.0, 5.0]);
//! let bvh = Bvh::new(&[wall, floor])?;
//!
//! let ray = Ray::new([0.0, 1.0, 0.0], [0.0, -0.5, 1.0]);
//! let hit = bvh.closest(&ray).unwrap();
//! assert_eq!((hit.triangle, hit.t), (1, 2.0));
//!
//! // A reflected ray, which never hits the triangle it starts from.
//! let reflected = bvh.spawn_ray(&hit, [0.0, 0.5, 1.0]);
//! assert_eq!(bvh.closest(&reflected).unwrap().triangle, 0);
//! # Ok::<(), intertri_trace::BuildError>(())
//! ```
//!
//! Traversal runs in f32 lanes with conservative boxes. Leaves use the filter of the kernel,
//! [`intertri`], and fall back to exact arithmetic where f32 cannot decide. As a result, the
//! hierarchy loses no hit, and no ray slips through a shared edge. Results depend only on the ray
//! and the triangles, not on the tree, the number of threads, the other rays of a batch, or the
//! CPU.
//!
//! # How to choose
//!
//! | you want | use |
//! | --- | --- |
//! | hits in `exact` mode, among all triangles | the shortcuts of [`Bvh`]: `closest`, `any`, `all`, `crossings`, `visible` |
//! | another mode, masks, culling, triangles to skip | [`Bvh::query`]; chain the settings of [`Query`], then call one of its methods |
//! | inside or outside, winding numbers, signed distances | [`Solid`], for closed meshes and for open and damaged ones |
//! | the media along a ray, through nested and touching solids | [`Media`] |
//! | how thick a solid is at a hit | [`Bvh::thickness`] |
//! | open edges, flipped and duplicate triangles of a mesh | [`Solid::inspect`] |
//! | the closest point on a mesh | [`Bvh::closest_point`] |
//! | the triangle of a hit, its normal, a secondary ray | [`Bvh::triangle`], [`Bvh::normal`], [`Bvh::spawn_ray`], [`Bvh::spawn_ray_to`] |
//! | many placements of a mesh, or objects that move | [`Scene`], whose [`commit`](Scene::commit) returns a snapshot to query |
//! | shadows, or whether two points see each other | [`Query::visible_batch`], which keeps surfaces from shading themselves |
//!
//! **One ray or many.** If you have many rays, use a batch. `closest_batch` and its siblings trace
//! coherent rays as bundles and all others as ray streams, using all threads. Batch methods return
//! new vectors; the `…_into` variants write to a slice that you can reuse. If you trace one ray at
//! a time, create one [`Query`] per thread and reuse it: it owns the traversal's scratch memory.
//!
//! ```
//! use intertri_trace::{Bvh, Faces};
//! use intertri_trace::intertri::{Hit, Mode, Ray, Triangle};
//! let at = |z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]);
//! let bvh = Bvh::from_meshes(&[&[at(3.0)], &[at(5.0), at(7.0)]])?;
//! let rays = [0.25, 2.0].map(|x| Ray::new([x, 0.25, 0.0], [0.0, 0.0, 1.0]));
//!
//! let hits = bvh.closest_batch(&rays);
//! assert!(hits[0].geometry == 0 && hits[1] == Hit::MISS);
//!
//! // Only back faces, with the bits of the scalar f64 reference, written to your own buffer.
//! let mut hits = [Hit::MISS; 2];
//! bvh.query().mode(Mode::certified()).faces(Faces::Back).closest_batch_into(&rays, &mut hits);
//! assert_eq!(hits[0].t, 3.0);
//! # Ok::<(), intertri_trace::BuildError>(())
//! ```
//!
//! **Which mode.** Keep [`Mode::exact`](intertri::Mode::exact), the default. Use [`Query::once`] if
//! a point on an edge or corner must belong to only one triangle, and `Mode::certified` if you need
//! the same bits as the scalar f64 reference.
//!
//! **f32 or f64.** A [`Bvh`] over [`Triangle`](type@intertri::Triangle) takes f32 coordinates. If
//! your coordinates are not exact in f32, for example in UTM, build over
//! [`Triangle64`](type@intertri::Triangle64): `Bvh<f64>` has the same methods and is exact for the
//! f64 coordinates you pass. It takes more memory and time; see [`Bvh`].
//!
//! **Input.** [`Bvh::new`] takes a slice of triangles, and [`Bvh::from_indexed`] takes vertices and
//! indices. [`Bvh::from_meshes`] and [`Bvh::from_indexed_meshes`] take several meshes, each of
//! which becomes a geometry with its own mask. [`Bvh::refit`] updates the hierarchy after vertices
//! have moved, and [`Bvh::load`] reads a file written by [`Bvh::write_to`]. [`Scene::load`] and
//! [`Scene::write_to`] do the same for scenes.
//!
//! # Features
//!
//! - `parallel` (default): builds, refits, and traces batches on all threads, using rayon.
//! - `std` (default): selects the CPU's best instruction set at run time. Without this
//!   feature, the crate uses the instructions it was compiled for, but still needs the standard
//!   library.
//!
//! # Threads
//!
//! Work runs in the rayon pool of the calling thread, which by default is the global one. To use
//! your own pool, make the call inside `ThreadPool::install`. [`Query::on_this_thread`] keeps a
//! batch on the calling thread. A [`Bvh`] can be shared between threads; a [`Query`] belongs to one
//! thread at a time.
//!
//! # Limits
//!
//! A hierarchy holds fewer than 2^31 triangles and no other primitives, such as curves or user
//! geometry. Triangles with a NaN or infinite coordinate are never hit, nor are triangles with zero
//! area. If memory runs out during a build, refit, or load, or while hits are collected in lists,
//! the call returns an error instead of aborting.
//!
//! Build in release mode, or at least optimize this crate and `intertri`; the front page of
//! [`intertri`] shows how.
mod batch;
mod build;
mod bvh;
mod containment;
mod instances;
mod media;
mod morton;
mod nearest;
mod query;
mod refit;
mod save;
mod scalar;
mod selection;
mod solid;
mod tree;
mod util;
mod walk;

pub use intertri;

pub use batch::{CrossingLists, HitLists, HitRecord, Lists};
pub use build::BuildError;
pub use bvh::{Bvh, IndexedMesh};
pub use containment::Containment;
pub use instances::{
    InstanceId, Scene, SceneClosestPoint, SceneError, SceneHit, SceneMesh, SceneSnapshot,
};
pub use media::{Media, MediaError, MediumCrossing, Segment};
pub use nearest::ClosestPoint;
pub use query::Query;
pub use refit::{Refit, RefitError};
pub use save::{LoadError, SAVED_MAGIC, SAVED_SCENE_MAGIC, SceneLoadError};
pub use scalar::BvhScalar;
pub use selection::Faces;
pub use solid::{DefectiveEdge, DuplicateTriangle, MeshReport, Orientation, Solid, SolidError};
pub use tree::MeshTriangle;
pub use util::memory::OutOfMemory;

/// Items that the Python package and the tests rely on. They may change without notice.
#[doc(hidden)]
pub mod internal {
    pub use crate::batch::rows::{Run, runs};
    pub use crate::batch::tiles::{Band, Block, LOWEST, TILE};
    pub use crate::save::{checksum, seal, seal_scene};
    pub use crate::solid::WINDING_DIR;
    pub use crate::util::stop::{StopToken, Stopped};
    pub use crate::util::threads::on_this_thread;
}
