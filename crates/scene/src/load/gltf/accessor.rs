//! Accessors: tables of numbers in a buffer.

use gltf::json::Root;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

use super::buffers::Buffers;
use crate::load::error::{Fault, fault};

/// A table whose rows all lie within its bytes.
pub(super) struct Accessor<'a> {
    bytes: &'a [u8],
    stride: usize,
    /// How many rows it has.
    pub(super) count: usize,
    component: ComponentType,
    normalized: bool,
}

impl<'a> Accessor<'a> {
    /// The accessor of that number, for `what`, whose rows must be of that type.
    pub(super) fn new(
        root: &Root,
        buffers: &'a Buffers<'_>,
        index: usize,
        (what, wanted): (&str, Type),
    ) -> Result<Self, Fault> {
        let wrong = |cause: &str| fault(format!("accessor {index}, for {what}, {cause}"));
        let Some(accessor) = root.accessors.get(index) else { return wrong("is not there") };
        if accessor.sparse.is_some() {
            return wrong("is sparse, which is not supported; export the model without that");
        }
        let Some(view) = accessor.buffer_view else {
            return wrong("has no data of its own; is the mesh compressed? export it without that");
        };
        let (Checked::Valid(component), Checked::Valid(kind)) =
            (accessor.component_type, accessor.type_)
        else {
            return wrong("has a type that glTF does not know");
        };
        if kind != wanted {
            return wrong(&format!("has rows of type {kind:?} and not {wanted:?}"));
        }

        // From where to where, in numbers that cannot overflow.
        let row = component.0.size() * kind.multiplicity();
        let stride = root.buffer_views.get(view.value()).and_then(|view| view.byte_stride);
        let stride = stride.map_or(row, |stride| if stride.0 == 0 { row } else { stride.0 });
        let from = u128::from(accessor.byte_offset.map_or(0, |offset| offset.0));
        let count = u128::from(accessor.count.0);
        let to = match count.checked_sub(1) {
            Some(last) => from + last * stride as u128 + row as u128,
            None => from,
        };
        let bytes = buffers.view(root, view.value())?;
        if to > bytes.len() as u128 || (stride < row && count > 1) {
            return wrong("reaches beyond its buffer view; is a file cut off?");
        }
        Ok(Self {
            bytes: &bytes[from as usize..to as usize],
            stride,
            count: count as usize,
            component: component.0,
            normalized: accessor.normalized,
        })
    }

    /// One row's numbers.
    fn row<const N: usize>(&self, row: usize) -> [f64; N] {
        let size = self.component.size();
        std::array::from_fn(|i| self.number(&self.bytes[row * self.stride + i * size..][..size]))
    }

    /// All rows. Integers that are normalized stand for 0 to 1, or -1 to 1.
    pub(super) fn rows<const N: usize>(&self) -> impl Iterator<Item = [f64; N]> {
        (0..self.count).map(|row| self.row(row))
    }

    /// All rows of a table of indices, which must be without sign.
    pub(super) fn indices(&self) -> Result<Vec<u32>, Fault> {
        match self.component {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => {
                Ok(self.rows().map(|[index]| index as u32).collect())
            }
            _ => fault("the indices of a mesh are no whole numbers without a sign"),
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
            // There is no other size.
            _ => f64::NAN,
        }
    }
}
