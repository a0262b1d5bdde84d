//! Reads accessors, which are tables of numbers in buffers.

use gltf::json::accessor::sparse::Sparse as SparseJson;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Index, Root, accessor, buffer};

use super::buffers::Buffers;
use crate::load::error::{Fault, fault};

/// A table whose rows are all within `bytes`.
pub(super) struct Accessor<'a> {
    /// The rows, one every `stride` bytes. The slice is empty for a sparse table that has no buffer
    /// view, in which every row that is not replaced is zero.
    bytes: &'a [u8],
    stride: usize,
    /// The number of rows.
    pub(super) count: usize,
    component: ComponentType,
    normalized: bool,
    replaced: SparseRows<'a>,
}

/// The rows that a sparse table replaces.
#[derive(Default)]
struct SparseRows<'a> {
    /// The rows' indices, in ascending order.
    rows: Vec<u32>,
    /// The new values, row by row.
    bytes: &'a [u8],
}

/// Looks up the tables of a file by index.
#[derive(Clone, Copy)]
pub(super) struct Tables<'a> {
    pub(super) root: &'a Root,
    pub(super) buffers: &'a Buffers<'a>,
}

impl<'a> Tables<'a> {
    /// Returns the table with this index, whose rows must have the type `wanted`. Error messages
    /// call the table `what`.
    pub(super) fn get(
        self,
        index: Index<accessor::Accessor>,
        (what, wanted): (&str, Type),
    ) -> Result<Accessor<'a>, Fault> {
        let index = index.value();
        let of = |fault: Fault| Fault {
            cause: format!("accessor {index}, for {what}, {}", fault.cause),
            ..fault
        };
        let Some(accessor) = self.root.accessors.get(index) else {
            return fault("does not exist").map_err(of);
        };
        self.read(accessor, wanted).map_err(of)
    }

    fn read(self, accessor: &'a accessor::Accessor, wanted: Type) -> Result<Accessor<'a>, Fault> {
        let (Checked::Valid(component), Checked::Valid(kind)) =
            (accessor.component_type, accessor.type_)
        else {
            return fault("has a type that glTF does not define");
        };
        if kind != wanted {
            return fault(format!("has rows of type {kind:?} and not {wanted:?}"));
        }
        let (component, row) = (component.0, component.0.size() * kind.multiplicity());
        let count = accessor.count.0;
        let (bytes, stride) = match accessor.buffer_view {
            Some(view) => {
                let stride = self.root.buffer_views.get(view.value());
                let stride = stride.and_then(|view| view.byte_stride).map_or(0, |stride| stride.0);
                let stride = if stride == 0 { row } else { stride };
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                (self.rows(view, offset, count, (row, stride))?, stride)
            }
            None if accessor.sparse.is_some() => (&[][..], row),
            None => {
                return fault("has no data; is the mesh compressed? export it without compression");
            }
        };
        let replaced = match &accessor.sparse {
            Some(sparse) => self.replaced(sparse, row, count)?,
            None => SparseRows::default(),
        };
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        let normalized = accessor.normalized;
        Ok(Accessor { bytes, stride, count, component, normalized, replaced })
    }

    /// Returns the bytes of `count` rows with the given size and stride.
    fn rows(
        self,
        view: Index<buffer::View>,
        offset: u64,
        count: u64,
        (row, stride): (usize, usize),
    ) -> Result<&'a [u8], Fault> {
        // Compute the start and end in integers that cannot overflow.
        let from = u128::from(offset);
        let to = match u128::from(count).checked_sub(1) {
            Some(last) => from + last * stride as u128 + row as u128,
            None => from,
        };
        let bytes = self.buffers.view(self.root, view.value())?;
        if to > bytes.len() as u128 || (stride < row && count > 1) {
            return fault("reaches beyond its buffer view; is a file cut off?");
        }
        Ok(&bytes[from as usize..to as usize])
    }

    /// Returns the rows that a sparse table of `count` rows replaces.
    fn replaced(
        self,
        sparse: &SparseJson,
        row: usize,
        count: u64,
    ) -> Result<SparseRows<'a>, Fault> {
        let Checked::Valid(kind) = sparse.indices.component_type else {
            return fault("has sparse indices of a type that glTF does not define");
        };
        let size = kind.0.size();
        let USize64(replaced) = sparse.count;
        let (indices, values) = (&sparse.indices, &sparse.values);
        let places =
            self.rows(indices.buffer_view, indices.byte_offset.0, replaced, (size, size))?;
        let bytes = self.rows(values.buffer_view, values.byte_offset.0, replaced, (row, row))?;
        let mut rows = Vec::new();
        rows.try_reserve(places.len() / size)?;
        rows.extend(places.chunks_exact(size).map(|bytes| {
            bytes.iter().rev().fold(0_u32, |number, &byte| number << 8 | u32::from(byte))
        }));
        let ascend = rows.windows(2).all(|pair| pair[0] < pair[1]);
        if !ascend || rows.last().is_some_and(|&last| u64::from(last) >= count) {
            return fault("has sparse indices that do not ascend or are out of range");
        }
        Ok(SparseRows { rows, bytes })
    }
}

impl Accessor<'_> {
    /// Returns the values in one row. Normalized integers are mapped to the range 0 to 1, or -1 to
    /// 1 if they are signed.
    pub(super) fn row<const N: usize>(&self, row: usize) -> [f64; N] {
        let size = self.component.size();
        let bytes = match self.replaced.rows.binary_search(&(row as u32)) {
            Ok(place) => &self.replaced.bytes[place * N * size..],
            Err(_) if self.bytes.is_empty() => return [0.0; N],
            Err(_) => &self.bytes[row * self.stride..],
        };
        std::array::from_fn(|i| self.number(&bytes[i * size..][..size]))
    }

    /// Iterates over all rows.
    pub(super) fn rows<const N: usize>(&self) -> impl Iterator<Item = [f64; N]> {
        (0..self.count).map(|row| self.row(row))
    }

    /// Returns all rows of an index table, whose components must be unsigned integers.
    pub(super) fn indices(&self) -> Result<Vec<u32>, Fault> {
        match self.component {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => {
                let mut indices = Vec::new();
                indices.try_reserve(self.count)?;
                indices.extend(self.rows().map(|[index]| index as u32));
                Ok(indices)
            }
            _ => fault("the indices of a mesh are not unsigned integers"),
        }
    }

    fn number(&self, bytes: &[u8]) -> f64 {
        let share = |x: f64, most: f64| if self.normalized { (x / most).max(-1.0) } else { x };
        match (self.component, bytes) {
            (ComponentType::I8, &[a]) => share(f64::from(a as i8), 127.0),
            (ComponentType::U8, &[a]) => share(f64::from(a), 255.0),
            (ComponentType::I16, &[a, b]) => share(f64::from(i16::from_le_bytes([a, b])), 32767.0),
            (ComponentType::U16, &[a, b]) => share(f64::from(u16::from_le_bytes([a, b])), 65535.0),
            (ComponentType::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]).into(),
            (ComponentType::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]).into(),
            // Components have no other size.
            _ => f64::NAN,
        }
    }
}
