//! Promise: the audit of time sees what it must.

use std::sync::OnceLock;

use tests::audit::cycle_audit::{self, Kernels};

fn kernels() -> &'static Kernels {
    static KERNELS: OnceLock<Result<Kernels, String>> = OnceLock::new();
    KERNELS.get_or_init(Kernels::build).as_ref().unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn report() {
    let report = cycle_audit::report(kernels(), &mut |what| eprintln!("{what}")).unwrap();
    for table in &report.tables {
        println!("{}\n{:?}", table.caption, table.header);
        for row in &table.rows { println!("{}", row.join(" | ")); }
    }
    println!("{:#?}", report.faults);
}
