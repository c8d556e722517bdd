//! What a monitor in `paper` mode says, as cells of a trace.

use monitor_core::paper::{Phase, Verdict};
use monitor_core::sample::ModelId;

use super::{TraceWriter, Traced};
use crate::names::{diagnosis_id, model_key};

impl Traced for Verdict {
    fn columns() -> Vec<String> {
        let models = ["t2", "relay"].iter().flat_map(|p| ModelId::ALL.map(|m| format!("{p}_{}", model_key(m))));
        ["phase", "rejected"].map(str::to_owned).into_iter().chain(models).chain(["located".to_owned()]).collect()
    }

    /// T2 cells are empty where nothing was judged.
    fn write_cells(&self, trace: &mut TraceWriter<Self>) -> csv::Result<()> {
        trace.text(match self.phase() {
            Phase::Settling(_) => "settling",
            Phase::Learning => "learning",
            Phase::ModelDue => "model due",
            Phase::Monitoring => "monitoring",
        })?;
        trace.flag(self.rejected().is_some())?;
        for model in ModelId::ALL {
            trace.number(self.residuals().map(|residuals| *residuals.get(model)))?;
        }
        for model in ModelId::ALL {
            trace.flag(*self.relays().get(model))?;
        }
        trace.text(diagnosis_id(self.diagnosis()).unwrap_or_default())
    }
}
