//! Computes XXH64 checksums with seed 0, as specified at <https://xxhash.com>. A checksum detects
//! damage, not tampering. Memory bandwidth limits the speed of the computation.

const P1: u64 = 0x9e37_79b1_85eb_ca87;
const P2: u64 = 0xc2b2_ae3d_27d4_eb4f;
const P3: u64 = 0x1656_67b1_9e37_79f9;
const P4: u64 = 0x85eb_ca77_c2b2_ae63;
const P5: u64 = 0x27d4_eb2f_1656_67c5;

/// Computes the XXH64 hash of a byte slice.
pub fn checksum(bytes: &[u8]) -> u64 {
    let mut stripes = bytes.chunks_exact(32);
    let mut sum = P5;
    if bytes.len() >= 32 {
        // Keep four independent sums, so that the CPU can update all of them at once.
        let mut lanes = [P1.wrapping_add(P2), P2, 0, 0_u64.wrapping_sub(P1)];
        for stripe in &mut stripes {
            for (lane, word) in lanes.iter_mut().zip(words(stripe)) {
                *lane = round(*lane, word);
            }
        }
        let [a, b, c, d] = lanes;
        sum = (a.rotate_left(1).wrapping_add(b.rotate_left(7)))
            .wrapping_add(c.rotate_left(12))
            .wrapping_add(d.rotate_left(18));
        for lane in lanes {
            sum = (sum ^ round(0, lane)).wrapping_mul(P1).wrapping_add(P4);
        }
    }
    sum = sum.wrapping_add(bytes.len() as u64);

    // Process the remaining bytes: whole words, then half a word, then single bytes.
    let mut left = stripes.remainder();
    while let Some((word, rest)) = left.split_first_chunk::<8>() {
        let mixed = sum ^ round(0, u64::from_le_bytes(*word));
        sum = mixed.rotate_left(27).wrapping_mul(P1).wrapping_add(P4);
        left = rest;
    }
    if let Some((half, rest)) = left.split_first_chunk::<4>() {
        let mixed = sum ^ u64::from(u32::from_le_bytes(*half)).wrapping_mul(P1);
        sum = mixed.rotate_left(23).wrapping_mul(P2).wrapping_add(P3);
        left = rest;
    }
    for &byte in left {
        sum = (sum ^ u64::from(byte).wrapping_mul(P5)).rotate_left(11).wrapping_mul(P1);
    }

    // Final avalanche: flipping any input bit changes about half of the output bits.
    sum = (sum ^ sum >> 33).wrapping_mul(P2);
    sum = (sum ^ sum >> 29).wrapping_mul(P3);
    sum ^ sum >> 32
}

#[inline(always)]
fn round(lane: u64, word: u64) -> u64 {
    lane.wrapping_add(word.wrapping_mul(P2)).rotate_left(31).wrapping_mul(P1)
}

/// Returns the 64-bit words of a stripe.
#[inline(always)]
fn words(stripe: &[u8]) -> impl Iterator<Item = u64> + '_ {
    stripe.as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word))
}

#[cfg(test)]
mod tests {
    use super::checksum;

    /// Compares hashes with the output of `xxhsum -H1`.
    #[test]
    fn it_is_xxh64() {
        let text = b"Nobody inspects the spammish repetition";
        assert_eq!(checksum(b""), 0xef46_db37_51d8_e999);
        assert_eq!(checksum(b"a"), 0xd24e_c4f1_a98c_6e5b);
        assert_eq!(checksum(b"abc"), 0x44bc_2cf5_ad77_0999);
        assert_eq!(checksum(text), 0xfbce_a83c_8a37_8bf1);
    }
}
