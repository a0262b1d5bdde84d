//! Lookup tables for the order in which rays of an octant visit the children of a node, which is
//! roughly front to back.

/// Returns the slots in a mask in reverse visiting order for rays of an octant: one slot per byte,
/// starting with the lowest byte.
#[inline(always)]
pub(crate) fn far_to_near(mask: u32, octant: usize) -> u64 {
    FAR_TO_NEAR[octant % 8][mask as usize % 256]
}

/// Returns the slot in a mask that rays of an octant visit first, or 8 if the mask is empty.
#[inline(always)]
pub(crate) fn first_slot(mask: u32, octant: usize) -> u8 {
    FIRST[octant % 8][mask as usize % 256]
}

/// For each octant and mask, the first slot in the mask, or 8 if the mask is empty.
static FIRST: [[u8; 256]; 8] = {
    let mut all = [[8; 256]; 8];
    let mut at = 0;
    while at < 8 * 256 {
        let (octant, mask) = (at / 256, at % 256);
        let mut i = 8;
        // Go from the last slot to the first, so that the slot visited first is written last.
        while i > 0 {
            i -= 1;
            if mask >> (i ^ octant) & 1 != 0 {
                all[octant][mask] = (i ^ octant) as u8;
            }
        }
        at += 1;
    }
    all
};

/// For each octant and mask, the slots in the mask in reverse visiting order: one slot per byte,
/// starting with the lowest byte.
static FAR_TO_NEAR: [[u64; 256]; 8] = {
    let mut all = [[0; 256]; 8];
    let mut at = 0;
    while at < 8 * 256 {
        let (octant, mask) = (at / 256, at % 256);
        let (mut i, mut place) = (8, 0);
        while i > 0 {
            i -= 1;
            if mask >> (i ^ octant) & 1 != 0 {
                all[octant][mask] |= ((i ^ octant) as u64) << (8 * place);
                place += 1;
            }
        }
        at += 1;
    }
    all
};

#[cfg(test)]
mod tests {
    use super::{FAR_TO_NEAR, FIRST};

    #[test]
    fn slots_of_an_octant_come_far_to_near() {
        for octant in 0..8 {
            for mask in 0..256_usize {
                let slots: Vec<usize> =
                    (0..8).map(|i| i ^ octant).filter(|slot| mask >> slot & 1 != 0).collect();
                let bytes = FAR_TO_NEAR[octant][mask].to_le_bytes();
                let far_to_near: Vec<usize> =
                    bytes[..slots.len()].iter().map(|&slot| slot.into()).collect();
                assert!(far_to_near.iter().rev().eq(&slots), "{octant} {mask:b}");
                assert_eq!(usize::from(FIRST[octant][mask]), *slots.first().unwrap_or(&8));
            }
        }
    }
}
