//! Order statistics for the tables.

use serde::Serialize;

/// Least, quartiles and greatest of some values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Least value.
    pub min: f64,
    /// A quarter lies below.
    pub lower_quartile: f64,
    /// Half lie below.
    pub median: f64,
    /// Three quarters lie below.
    pub upper_quartile: f64,
    /// Greatest value.
    pub max: f64,
}

impl Spread {
    /// The spread of `values`; none if there are none. Quantiles are interpolated between neighbours (Hyndman, Fan 1996,
    /// type 7).
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let (min, max) = (*sorted.first()?, *sorted.last()?);
        let at = |share: f64| {
            let place = share * (sorted.len() - 1) as f64;
            let (below, above) = (sorted[place as usize], sorted[place.ceil() as usize]);
            below + (above - below) * place.fract()
        };
        Some(Self { min, lower_quartile: at(0.25), median: at(0.5), upper_quartile: at(0.75), max })
    }
}

/// A share in percent for a table; a dash where nothing was counted.
#[must_use]
pub fn percent(count: usize, of: usize) -> String {
    if of == 0 { "-".to_owned() } else { format!("{:.1}", 100.0 * count as f64 / of as f64) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_interpolated_between_neighbours() {
        // numpy.quantile([1, 2, 3, 10], [0.25, 0.5, 0.75]) = 1.75, 2.5, 4.75.
        let spread = Spread::of([3.0, 1.0, 10.0, 2.0]);
        let expected = Spread { min: 1.0, lower_quartile: 1.75, median: 2.5, upper_quartile: 4.75, max: 10.0 };
        assert_eq!(spread, Some(expected));
        assert_eq!(Spread::of([]), None);
    }
}
