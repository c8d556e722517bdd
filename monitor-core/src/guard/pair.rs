//! The metric of the pair that is left when a channel is lost.

use super::flag::Flag;
use crate::root::reciprocal_sqrt;
use crate::triangle::{Triangle, inner};

impl Triangle<3> {
    /// The metric of least distances over all values of the lost channel, which are the distances of the pair without it; the
    /// metric itself when no bit of `lost` is set. The same operations whichever is.
    ///
    /// Rows are rotated against each other until one holds all that the channel's column has; that one is left out.
    pub(super) fn without(&self, lost: u32) -> Self {
        let [first, second, third] = self.rows();
        let column = [0, 1, 2].map(|place| (lost >> place & 1) as f32);
        let [u, v, w] = [first, second, third].map(|row| inner(row, column));
        let (second, rest, length) = rotated((second, v), (third, w));
        let (first, rest, _) = rotated((first, u), (rest, length));
        let whole = !Flag::any(lost);
        Triangle::from_upper([first, second, rest.map(|cell| whole.or_zero(cell))])
    }
}

/// Rotates two rows with these entries in the column: the first then has nothing in it, the second the length that is
/// returned. Where neither has an entry both stay as they are.
#[inline(always)]
fn rotated((a, s): ([f32; 3], f32), (b, t): ([f32; 3], f32)) -> ([f32; 3], [f32; 3], f32) {
    let square = s * s + t * t;
    let empty = Flag::below(square, 1e-37);
    let per_length = reciprocal_sqrt(empty.choose(1.0, square));
    let (cos, sin) = (empty.choose(1.0, t * per_length), s * per_length);
    let ([a0, a1, a2], [b0, b1, b2]) = (a, b);
    (
        [cos * a0 - sin * b0, cos * a1 - sin * b1, cos * a2 - sin * b2],
        [sin * a0 + cos * b0, sin * a1 + cos * b1, sin * a2 + cos * b2],
        square * per_length,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle::square;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_distance_without_a_channel_is_the_least_over_all_of_its_values(
            rows in prop::array::uniform3(prop::array::uniform3(-3.0_f32..3.0)),
            diagonal in prop::array::uniform3(0.5_f32..3.0), y in prop::array::uniform3(-10.0_f32..10.0),
            place in 0_usize..3,
        ) {
            let [[_, b, c], [_, _, e], _] = rows;
            let [a, d, f] = diagonal;
            let metric = Triangle::from_upper([[a, b, c], [0.0, d, e], [0.0, 0.0, f]]);
            prop_assert_eq!(metric.without(0), metric);
            // Of a parabola in the channel's value, through three points.
            let at = |value: f64| {
                let mut y = y.map(f64::from);
                y[place] = value;
                let row = |row: [f32; 3]| row.iter().zip(y).map(|(u, y)| f64::from(*u) * y).sum::<f64>();
                metric.rows().map(|cells| row(cells).powi(2)).iter().sum::<f64>()
            };
            let (middle, slope, bend) = (at(0.0), 0.5 * (at(1.0) - at(-1.0)), 0.5 * (at(1.0) + at(-1.0)) - at(0.0));
            let least = (middle - slope * slope / (4.0 * bend)) as f32;
            let largest = middle as f32;
            let mut known = y;
            known[place] = 0.0;
            let found = metric.without(1 << place).square_of(known);
            prop_assert!((found - least).abs() <= 1e-5 * largest + 1e-4, "{} for {}", found, least);
            // Nor does it matter what the lost channel says.
            let away = metric.without(1 << place).square_of(y);
            prop_assert!((away - found).abs() <= 1e-5 * square(y) * 100.0 + 1e-4, "{} for {}", away, found);
        }
    }
}
