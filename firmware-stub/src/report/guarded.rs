//! The lines of `guard` mode.

use monitor_core::guard::{Cause, Explanation, Finding};

use super::{Report, Spoken, healthy};
use crate::background::Named;
use crate::mode::guarded::{Guarded, News, What};

impl Spoken for Guarded {
    fn log_news(report: &Report<Self>, News { sample, what }: News) {
        let at = report.us(sample);
        match what {
            What::Phase(phase) => defmt::info!("{=u64:us} s: {}", at, phase),
            What::Raised { since, severity } => defmt::warn!(
                "{=u64:us} s: alarm since {=u64:us} s, distance {=f32} of its limit",
                at,
                report.us(since),
                severity
            ),
            What::Withdrawn { since } => {
                defmt::info!("{=u64:us} s: alarm withdrawn that stood since {=u64:us} s", at, report.us(since));
            }
            What::Lost(channel, loss) => defmt::warn!("{=u64:us} s: sensor lost, {} {}", at, channel, loss),
            What::Back(channel) => defmt::info!("{=u64:us} s: sensor back, {}", at, channel),
            What::Gap => defmt::warn!("{=u64:us} s: gap, no samples come", at),
            What::GapOver => defmt::info!("{=u64:us} s: samples come again", at),
            What::Refused(error) => defmt::warn!("{=u64:us} s: learning refused, {}", at, error),
            What::Learned(quality) => defmt::info!(
                "{=u64:us} s: learned from {=u32} samples, {=f32} of them clipped, condition {=f32}, drift {=f32} sigma, \
                 variance of the slow scale {=f32} times that of white noise",
                at,
                quality.samples,
                quality.clipped_share,
                quality.condition,
                quality.drift_sigmas,
                quality.slow_variance_ratio
            ),
        }
    }

    fn log_named(report: &Report<Self>, named: &Named<Finding>) {
        let (at, since) = (report.us(named.sample), report.us(named.since.unwrap_or(named.sample)));
        match &named.finding {
            Finding::Fault(found) | Finding::Ambiguous(found, _) => {
                let Explanation { cause, size, size_sigma, .. } = found;
                let unit = unit(*cause);
                defmt::warn!(
                    "{=u64:us} s: fault {}, alarm since {=u64:us} s, size {=f32} {=istr}, sigma {=f32}",
                    at,
                    cause,
                    since,
                    size,
                    unit,
                    size_sigma
                );
                if let Finding::Ambiguous(_, other) = named.finding {
                    defmt::warn!("{=u64:us} s: or fault {}, which looks the same here", at, other);
                }
            }
            _ => defmt::warn!("{=u64:us} s: something is wrong since {=u64:us} s, but no known fault", at, since),
        }
    }

    fn log_by_channel(deviation: Option<[f32; 3]>) {
        match deviation {
            Some([speed, current, voltage]) => defmt::info!(
                "deviation from healthy: speed {=f32} rad/s, armature current {=f32} A, armature voltage {=f32} V",
                speed,
                current,
                voltage
            ),
            None => defmt::info!("deviation from healthy: none, nothing is judged yet"),
        }
    }

    fn log_verdict(&self, report: &Report<Self>, finding: &Finding) {
        let verdict = self.monitor().verdict();
        defmt::info!("{=u64:us} s: {}, {}", report.us(verdict.sample()), verdict, finding);
    }

    fn log_statistics(&self) {
        if let Some(model) = self.monitor().model() {
            healthy(model.mean(), model.sigma());
        }
        defmt::info!("limits {}, {}", self.monitor().limits(), self.monitor().quality());
    }
}

/// The unit of a fault's size.
fn unit(cause: Cause) -> defmt::Str {
    match cause {
        Cause::LoadTorque => defmt::intern!("N m"),
        Cause::SpeedSensor => defmt::intern!("rad/s"),
        Cause::CurrentSensor => defmt::intern!("A"),
        Cause::Resistance => defmt::intern!("ohm"),
        Cause::TorqueConstant => defmt::intern!("N m/A"),
        Cause::Supply => defmt::intern!("V"),
        _ => defmt::intern!(""),
    }
}
