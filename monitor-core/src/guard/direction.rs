//! Localization by direction: each fault moves the readings along a direction of its own, and the fault whose direction
//! explains the deviation best is the one.
//!
//! A deviation z is taken as s d + noise, for a fault of size s whose readings move by d per unit. Directions come from
//! constants that are known to some percent, so d is itself uncertain: each of its entries by a share of itself, and an entry
//! that is zero for a physical reason stays zero. With S the covariance of the noise and E that of the direction's
//! uncertainty, z - s d has the covariance C = S + s^2 E, the size is d'C^-1 z/(d'C^-1 d) (generalized least squares),
//! and how badly a fault fits is (z - s d)'C^-1 (z - s d) + ln det C, minus twice the logarithm of its likelihood. The best fit
//! is the fault; how much worse the next one fits says how sure that is.

use heapless::Vec;

use crate::root::square_root;
use crate::triangle::inner;

/// Most faults that can be told apart.
pub(super) const CAPACITY: usize = 8;

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Cause {
    /// The load on the propeller has changed, N m: debris, a cord around the shaft; a lost blade if negative.
    LoadTorque,
    /// The speed sensor is off, rad/s.
    SpeedSensor,
    /// The armature-current sensor is off, A.
    CurrentSensor,
    /// The resistance of winding, brushes or a connector has grown, ohm.
    Resistance,
    /// The magnets have lost torque constant, N m/A.
    TorqueConstant,
    /// The supply gives less than it is told, V.
    Supply,
}

/// The movement of the readings (speed, current, voltage) by one unit of a fault, in a speed loop with integral action that
/// has settled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// The fault.
    pub cause: Cause,
    /// The readings' movement, each in its unit per unit of the fault.
    pub movement: [f32; 3],
    /// Relative standard deviation of each entry of the movement, independent of the others: how well the fault can be told from
    /// others.
    pub tolerance: f32,
    /// Relative standard deviation of all entries alike: how well its size is known.
    pub scale_tolerance: f32,
    /// Whether the fault can only be positive.
    pub one_sided: bool,
}

/// What is known of the motor at its set point. Within 20 % will do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorConstants {
    /// Armature resistance, ohm.
    pub resistance_ohm: f32,
    /// Torque constant, N m/A, which is also the speed constant in V s/rad.
    pub torque_constant_nm_per_a: f32,
    /// How much the load torque grows with speed at the set point, N m s/rad.
    pub load_slope_nm_s: f32,
}

/// Why directions were refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DirectionError {
    /// A motor constant must be finite; resistance and torque constant above zero, the slope of the load not below.
    MotorConstants,
    /// A direction must be finite, and move some reading.
    Movement(Cause),
    /// A tolerance must be finite and not negative.
    Tolerance(Cause),
    /// There is no room for another.
    Full,
}

/// The directions of the faults that are considered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Directions(Vec<Direction, CAPACITY>);

/// What a deviation is taken for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Finding {
    /// Nothing deviates.
    Healthy,
    /// The loop is still moving: a name would be a guess.
    Locating,
    /// This fault.
    Fault(Explanation),
    /// Two that cannot be told apart here: the better explanation, and the other.
    Ambiguous(Explanation, Cause),
    /// None of the faults considered explains it.
    Unknown,
}

/// How a fault explains a deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Explanation {
    /// The fault.
    pub cause: Cause,
    /// Its size, in its unit.
    pub size: f32,
    /// Standard deviation of the size, in its unit: by noise, and by constants that are known to the direction's tolerance.
    pub size_sigma: f32,
    /// Squared distance of the deviation from what the fault makes of the readings: three on average if it is the one.
    pub misfit: f32,
    /// The next best, and the logarithm of by how much it is less likely.
    pub runner_up: Option<(Cause, f32)>,
}

/// Relative standard deviation of a constant that is known within 20 %, every error up to that being as likely.
pub const TOLERANCE_OF_CONSTANTS: f32 = 0.115;

/// Relative standard deviation of what moves by these powers of resistance, torque constant and slope.
fn tolerance(powers: [f32; 3]) -> f32 {
    TOLERANCE_OF_CONSTANTS * square_root(inner(powers, powers))
}

/// Share of a deviation by which a fault need not fit it.
const FITS_TO: f32 = 0.1;

/// Largest misfit that is no other fault: a chi-square of three exceeds it once in a thousand.
const MISFIT_TO: f32 = 16.3;

/// Two faults cannot be told apart if the likelihood of the one is less than this many times that of the other, in ln: 1 in 10.
/// By a sweep over motors that nothing was scored on (`GUARD.md`).
const APART_FROM: f32 = 2.3;

/// The same without noise, for noise and errors of the constants to leave that in 99 cases of 100: the logarithm of a likelihood
/// ratio of mean m varies by 2m, and m - 2.33 sqrt(2m) is `APART_FROM` at this m.
const FORETOLD_FROM: f32 = 15.1;

/// The noise in a deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Its covariance, by columns, in the channels' units.
    pub covariance: [[f32; 3]; 3],
    /// Standard deviation of single readings of each channel, in its unit: the scale by which a length is a length.
    pub sigma: [f32; 3],
    /// Share of a deviation, its length and each reading in sigmas, by which a reading may be off: loops are not quite settled,
    /// and motors not quite linear.
    pub settled_to: f32,
}

impl Noise {
    /// With a share of the deviation's length by which readings may be off.
    fn of(&self, deviation: [f32; 3], share: f32) -> Covariance {
        let mut length = 0.0;
        for (z, s) in deviation.into_iter().zip(self.sigma) {
            length += (z / s) * (z / s);
        }
        let mut covariance = self.covariance;
        for (i, (column, s)) in covariance.iter_mut().zip(self.sigma).enumerate() {
            if let Some(variance) = column.get_mut(i) {
                *variance += share * share * length * s * s;
            }
        }
        covariance
    }
}

impl Directions {
    /// No directions: everything is unknown.
    #[must_use]
    pub const fn none() -> Self {
        Directions(Vec::new())
    }

    /// The directions of all causes, from the motor's constants and its mean readings at the set point.
    ///
    /// The loop holds the measured speed at the set point, so no fault moves it in the end. From the balance of torque
    /// K i = T(w) and of voltage u = R i + K w:
    /// - load torque: i by 1/K, u by R/K;
    /// - speed sensor, reading 1 too much: the motor turns slower by 1, i by -T'/K, u by -(K + R T'/K);
    /// - current sensor: its reading by 1, nothing else;
    /// - resistance: u by i; torque constant, 1 less: i by i/K, u by R i/K - w; supply: u by 1.
    ///
    /// # Errors
    /// [`DirectionError::MotorConstants`].
    pub fn of_motor(motor: &MotorConstants, mean: [f32; 3]) -> Result<Self, DirectionError> {
        let MotorConstants { resistance_ohm: r, torque_constant_nm_per_a: k, load_slope_nm_s: slope } = *motor;
        let usable = r > 0.0 && k > 0.0 && slope >= 0.0 && (r + k + slope).is_finite();
        let [w, i, _] = mean;
        if !(usable && w.is_finite() && i.is_finite()) {
            return Err(DirectionError::MotorConstants);
        }
        // A fault is told from another by the ratio of its entries, and that moves with the constants by these powers of R, K and
        // slope: a load's is R; a speed sensor's slope/(K^2 + R slope), of which K^2 is the share q; the magnets' i/(R i - K w).
        // What both entries are off by alike is in the size.
        let q = k * k / (k * k + r * slope);
        let of_sensor = if slope > 0.0 { [1.0 - q, 2.0 * q, q] } else { [0.0; 3] };
        let magnets = r * i - k * w;
        let (share, rest) = if magnets.abs() > 0.0 { (r * i / magnets, k * w / magnets) } else { (1.0, 1.0) };
        // Grown resistance and weak magnets act with the sign of current and speed.
        let movements = [
            (Cause::LoadTorque, [0.0, 1.0 / k, r / k], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            (Cause::SpeedSensor, [0.0, -slope / k, -(k + r * slope / k)], of_sensor, [1.0 - q, 2.0 * q - 1.0, 1.0 - q]),
            (Cause::CurrentSensor, [0.0, 1.0, 0.0], [0.0; 3], [0.0; 3]),
            (Cause::Resistance, [0.0, 0.0, i], [0.0; 3], [0.0; 3]),
            (Cause::TorqueConstant, [0.0, i / k, magnets / k], [share, rest, 0.0], [share, share, 0.0]),
        ];
        let mut directions = Directions::none();
        for (cause, movement, of_ratio, of_scale) in movements {
            // A motor at rest shows neither resistance nor magnets.
            if movement.iter().any(|m| m.abs() > 0.0) {
                directions.push(Direction {
                    cause,
                    movement,
                    // Two entries that are off independently.
                    tolerance: tolerance(of_ratio) * core::f32::consts::FRAC_1_SQRT_2,
                    scale_tolerance: tolerance(of_scale),
                    one_sided: matches!(cause, Cause::Resistance | Cause::TorqueConstant),
                })?;
            }
        }
        Ok(directions)
    }

    /// Adds a direction, or replaces that of the same cause: one from configuration, or as observed while commissioning, when
    /// a known offset is added to a reading in software and the mean readings move by `after - before`:
    /// `movement = (after - before)/offset`.
    ///
    /// # Errors
    /// [`DirectionError::Movement`], [`DirectionError::Tolerance`], [`DirectionError::Full`].
    pub fn push(&mut self, direction: Direction) -> Result<(), DirectionError> {
        let movement = direction.movement;
        let tolerances = [direction.tolerance, direction.scale_tolerance];
        if !tolerances.iter().all(|tolerance| *tolerance >= 0.0 && tolerance.is_finite()) {
            return Err(DirectionError::Tolerance(direction.cause));
        }
        if !(movement.iter().all(|m| m.is_finite()) && movement.iter().any(|m| m.abs() > 0.0)) {
            return Err(DirectionError::Movement(direction.cause));
        }
        if let Some(same) = self.0.iter_mut().find(|other| other.cause == direction.cause) {
            *same = direction;
            return Ok(());
        }
        self.0.push(direction).map_err(|_| DirectionError::Full)
    }

    /// The directions.
    pub fn iter(&self) -> impl Iterator<Item = &Direction> {
        self.0.iter()
    }

    /// What the monitor would say of this fault at this size: whether it can be told apart from the others is what a mission must
    /// know beforehand. `Fault` is what it says in 99 cases of 100, whatever the noise is and by as much as the constants may be off;
    /// what it would say less often is `Ambiguous`.
    #[must_use]
    pub fn rehearse(&self, cause: Cause, size: f32, noise: &Noise) -> Finding {
        let Some(direction) = self.0.iter().find(|direction| direction.cause == cause) else { return Finding::Unknown };
        self.explain_from(FORETOLD_FROM, direction.movement.map(|d| size * d), noise)
    }

    /// What explains a deviation best.
    #[must_use]
    pub fn explain(&self, deviation: [f32; 3], noise: &Noise) -> Finding {
        self.explain_from(APART_FROM, deviation, noise)
    }

    /// The same if the next best must be so much less likely, in ln.
    fn explain_from(&self, apart_from: f32, deviation: [f32; 3], noise: &Noise) -> Finding {
        let covariance = noise.of(deviation, noise.settled_to);
        let (mut best, mut next) = (None::<(&Direction, Fit)>, None::<Fit>);
        for direction in &self.0 {
            let Some(fit) = Fit::of(direction, deviation, &covariance) else { continue };
            match best {
                Some((_, leader)) if leader.badness <= fit.badness => {
                    next = next.filter(|next| next.badness <= fit.badness).or(Some(fit));
                }
                _ => {
                    next = best.map(|(_, leader)| leader);
                    best = Some((direction, fit));
                }
            }
        }
        let Some((direction, best)) = best else { return Finding::Unknown };
        // What still moves must not make a fault that fits better than any other an unknown one.
        let generous = noise.of(deviation, noise.settled_to.max(FITS_TO));
        let misfit = Fit::of(direction, deviation, &generous).map(|fit| fit.explanation.misfit);
        let Some(misfit) = misfit.filter(|misfit| *misfit <= MISFIT_TO) else { return Finding::Unknown };
        let explanation = Explanation { misfit, ..best.explanation };
        let Some(next) = next else { return Finding::Fault(explanation) };
        let (other, apart) = (next.explanation.cause, 0.5 * (next.badness - best.badness));
        let explanation = Explanation { runner_up: Some((other, apart)), ..explanation };
        if apart < apart_from { Finding::Ambiguous(explanation, other) } else { Finding::Fault(explanation) }
    }
}

/// How one fault fits a deviation.
#[derive(Clone, Copy, Debug)]
struct Fit {
    explanation: Explanation,
    /// Minus twice the logarithm of its likelihood, but for what is the same for all.
    badness: f32,
}

impl Fit {
    /// The best fit; none where the fault could only fit with the wrong sign, or numbers are out of range.
    fn of(direction: &Direction, deviation: [f32; 3], noise: &Covariance) -> Option<Self> {
        let Direction { cause, movement, tolerance, scale_tolerance, one_sided } = *direction;
        let uncertainty = movement.map(|d| tolerance * d);
        let mut size = 0.0;
        // The uncertainty of the direction grows with the size: from none, three rounds settle it to a percent.
        for _ in 0..3 {
            let whitened = Whitening::of(noise, uncertainty.map(|u| size * u))?;
            let (d, z) = (whitened.apply(movement), whitened.apply(deviation));
            size = inner(d, z) / inner(d, d);
        }
        let whitened = Whitening::of(noise, uncertainty.map(|u| size * u))?;
        let (d, z) = (whitened.apply(movement), whitened.apply(deviation));
        let mut residual = z;
        for (r, d) in residual.iter_mut().zip(d) {
            *r -= size * d;
        }
        let misfit = inner(residual, residual);
        let of_scale = scale_tolerance * size;
        let size_sigma = square_root(1.0 / inner(d, d) + of_scale * of_scale);
        let usable = misfit.is_finite() && size_sigma.is_finite() && (size > 0.0 || !one_sided);
        let explanation = Explanation { cause, size, size_sigma, misfit, runner_up: None };
        usable.then_some(Fit { explanation, badness: misfit + whitened.log_determinant })
    }
}

/// A covariance by columns.
pub(super) type Covariance = [[f32; 3]; 3];

/// The triangle L^-1 of a covariance C = L L' (Cholesky), by which noise of that covariance becomes white.
#[derive(Clone, Copy, Debug)]
struct Whitening {
    lower: Covariance,
    log_determinant: f32,
}

impl Whitening {
    /// Of a noise with some more on the diagonal; none if that is no covariance.
    fn of(noise: &Covariance, more: [f32; 3]) -> Option<Self> {
        let [[a, b, c], [_, d, e], [_, _, f]] = *noise;
        let [x, y, z] = more;
        let root = |square: f32| (square > 0.0 && square.is_finite()).then(|| square_root(square));
        let l00 = root(a + x * x)?;
        let (l10, l20) = (b / l00, c / l00);
        let l11 = root(d + y * y - l10 * l10)?;
        let l21 = (e - l20 * l10) / l11;
        let l22 = root(f + z * z - l20 * l20 - l21 * l21)?;
        let log_determinant = 2.0 * (libm::logf(l00) + libm::logf(l11) + libm::logf(l22));
        Some(Whitening { lower: [[l00, l10, l20], [0.0, l11, l21], [0.0, 0.0, l22]], log_determinant })
    }

    /// L^-1 x, by substitution.
    fn apply(&self, x: [f32; 3]) -> [f32; 3] {
        let ([[l00, l10, l20], [_, l11, l21], [_, _, l22]], [x, y, z]) = (self.lower, x);
        let first = x / l00;
        let second = (y - l10 * first) / l11;
        [first, second, (z - l20 * first - l21 * second) / l22]
    }
}

#[cfg(test)]
mod tests;
