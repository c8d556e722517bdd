//! The numbers the paper prints, for the columns beside ours.

/// A row of the paper's Table 1 or 2: when it detected a fault and when it saw its end, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperRow {
    /// Identifier of the fault.
    pub id: &'static str,
    /// When the fault starts in the paper's scenario (figure 1).
    pub start_s: f64,
    /// Column DETECTED.
    pub detected_s: f64,
    /// Column DETECT. END.
    pub cleared_s: f64,
}

const fn row(id: &'static str, start_s: f64, detected_s: f64, cleared_s: f64) -> PaperRow {
    PaperRow { id, start_s, detected_s, cleared_s }
}

/// Table 1, PCA.
pub const TABLE_1: [PaperRow; 3] =
    [row("F1", 20.0, 20.65, 46.95), row("F2", 60.0, 60.07, 90.43), row("F3", 100.0, 102.67, 122.33)];

/// Table 2, PPCA.
pub const TABLE_2: [PaperRow; 3] =
    [row("F1", 20.0, 21.3, 41.67), row("F2", 60.0, 60.16, 82.9), row("F3", 100.0, 102.67, 120.33)];

/// Value of each fault when its ramp is detected (III.C, the second figure 11). The paper gives neither the units nor
/// the motor, so these stand beside ours for orientation only.
pub const RAMP_VALUES: [(&str, f64); 3] = [("F1", 2.5), ("F2", 0.3), ("F3", 2.0)];

/// The row of a table for a fault, if the fault is timed as in the paper.
#[must_use]
pub fn counterpart(table: &[PaperRow; 3], id: &str, start_s: f64) -> Option<PaperRow> {
    table.iter().find(|row| row.id == id && (row.start_s - start_s).abs() < 1e-9).copied()
}
