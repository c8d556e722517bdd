//! What a monitor in `guard` mode says, as cells of a trace.

use monitor_core::guard::{Phase, SCALES};

use super::{TraceWriter, Traced};
use crate::guardian::Said;

impl Traced for Said {
    fn columns() -> Vec<String> {
        let columns = [
            "phase",
            "rejected",
            "severity_fast",
            "severity_middle",
            "severity_slow",
            "severity_trend",
            "alarm",
            "recovering",
            "located",
            "size",
        ];
        columns.map(str::to_owned).into()
    }

    /// Severities, distances over their limits, are empty where nothing was judged.
    fn write_cells(&self, trace: &mut TraceWriter<Self>) -> csv::Result<()> {
        let verdict = &self.verdict;
        trace.text(match verdict.phase() {
            Phase::Settling => "settling",
            Phase::Seeding => "seeding",
            Phase::Learning => "learning",
            Phase::ModelDue => "model due",
            Phase::Monitoring => "monitoring",
            Phase::Withheld => "withheld",
        })?;
        trace.flag(verdict.rejected())?;
        match verdict.severity() {
            Some(severity) => severity.into_iter().try_for_each(|severity| trace.number(Some(severity)))?,
            None => (0..SCALES).try_for_each(|_| trace.number(None))?,
        }
        trace.flag(verdict.alarm())?;
        trace.flag(verdict.recovering())?;
        trace.text(self.found.map_or("", |found| found.name.id()))?;
        trace.number(self.found.and_then(|found| found.size).map(|size| size.value as f32))
    }
}
