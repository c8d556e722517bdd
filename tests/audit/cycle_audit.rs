//! The audit of time: exact paths over thousands of inputs, cycles by the model, and the proof that a path is the only one.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use firmware_stub::kernels::Request;

use super::code::Code;
use super::control_flow::Graph;
use super::cycles::{self, Cost};
use super::forbidden;
use super::image::Image;
use super::inputs::{self, Question};
use super::report::{Figure, Report, Table};
use super::taint::{self, Proof};
use super::trace;
use crate::toolchain::{Firmware, compile_c, workspace};

/// What the audit cannot see.
const BLIND_SPOTS: [&str; 3] = [
    "instructions are exact; cycles are a model (Arm DDI 0439, no wait states): flash wait states, prefetch and caches, \
     and other masters on the bus are not in it, and nothing was measured on silicon",
    "an interrupt adds its entry of 12 cycles, and up to 17 where floating-point registers are stacked at once, and its exit",
    "the proof takes the set point, counters and the phase for control: it holds for each phase by itself",
];

/// Clock of the controller and rates of its sampling interrupt, Hz.
const CORE_HZ: f64 = 168e6;
const RATES_HZ: [f64; 2] = [1e3, 10e3];

/// Labels whose proof must hold.
const PROVEN: [&str; 21] = [
    inputs::MONITORING,
    inputs::SWITCHING,
    inputs::LEARNING,
    inputs::LEARNING_JOIN,
    inputs::GUARD_SEEDING,
    inputs::GUARD_LEARNING,
    inputs::GUARD_MONITORING,
    inputs::GUARD_TURN,
    inputs::PUSH,
    inputs::PUSH_JOIN,
    inputs::EIGEN_2,
    inputs::CORRELATION_2,
    inputs::EIGEN_3,
    inputs::CORRELATION_3,
    inputs::FILTER,
    inputs::FIRST_ORDER,
    inputs::COMPENSATED,
    inputs::COMPENSATED_FIRST_ORDER,
    inputs::MOVING_AVERAGE,
    inputs::EWMA,
    inputs::T2,
];

/// The firmware that calls every audited function.
#[derive(Clone, Debug)]
pub struct Kernels {
    /// The ELF file.
    pub elf: PathBuf,
    /// Its contents.
    pub image: Image,
    /// Its program.
    pub code: Code,
    /// It holds the peers in C.
    pub with_c: bool,
}

impl Kernels {
    /// Builds it, with peers in C if their compiler is installed.
    ///
    /// # Errors
    /// What is missing or went wrong, and what helps.
    pub fn build() -> Result<Self, String> {
        let object = compile_c(&workspace().join("tests/audit/peers/peers.c"))?;
        let features = if object.is_some() { "c-peers" } else { "audit-kernels" };
        let object_file = object.as_deref().map(|path| path.display().to_string());
        let plain = Firmware::emulated("audit-kernels");
        let link: Vec<&str> = plain.link.iter().copied().chain(object_file.as_deref()).collect();
        let elf = Firmware { features, link: &link, guarded: false, ..plain }.build()?;
        let image = Image::read(&elf)?;
        let code = Code::decode(&image)?;
        Ok(Kernels { elf, image, code, with_c: object.is_some() })
    }
}

/// What was seen of one label over all of its calls.
#[derive(Clone, Debug, Default)]
pub struct Observed {
    /// Calls.
    pub calls: u64,
    /// The cost of each call, in no order.
    pub costs: Vec<Cost>,
    /// Different paths.
    pub paths: BTreeSet<usize>,
    /// Bytes of the functions that were executed.
    pub bytes: u64,
}

impl Observed {
    fn instructions(&self) -> Vec<u64> {
        let mut all: Vec<u64> = self.costs.iter().map(|cost| cost.instructions).collect();
        all.sort_unstable();
        all
    }

    /// The largest of a figure over all calls.
    pub fn largest(&self, of: impl Fn(&Cost) -> u64) -> u64 {
        self.costs.iter().map(of).max().unwrap_or_default()
    }
}

/// Traces every question.
///
/// # Errors
/// The run fails, or the firmware answers something else than the host.
pub fn observe(kernels: &Kernels, questions: &[Question]) -> Result<BTreeMap<&'static str, Observed>, String> {
    let requests: Vec<Request> = questions.iter().map(|question| question.request).collect();
    let seen = trace::calls(&kernels.elf, &kernels.code, &requests)?;
    for (place, (question, answer)) in questions.iter().zip(&seen.answers).enumerate() {
        if question.expected.is_some_and(|expected| expected != *answer) {
            return Err(format!("request {place}, {:?}: the firmware's result is not the host's", question.request));
        }
    }
    let costs = seen.paths.iter().map(|path| cycles::cost(&kernels.code, path)).collect::<Result<Vec<_>, _>>()?;
    let called = questions.iter().filter(|question| !question.request.kernel.symbol().is_empty());
    let (mut observed, mut used) = (BTreeMap::<_, Observed>::new(), BTreeMap::<_, BTreeSet<u32>>::new());
    for (question, call) in called.zip(&seen.calls).filter(|(question, _)| !question.label.is_empty()) {
        let row = observed.entry(question.label).or_default();
        row.calls += 1;
        row.costs.extend(costs.get(call.path));
        if row.paths.insert(call.path) {
            let places = seen.paths.get(call.path).into_iter().flatten();
            let functions = places.filter_map(|pc| kernels.code.function_at(*pc)).map(|function| function.start);
            used.entry(question.label).or_default().extend(functions);
        }
    }
    for (label, functions) in used {
        let sizes = functions.iter().filter_map(|start| kernels.code.functions.get(start)).map(|f| f.end - f.start);
        observed.entry(label).or_default().bytes = u64::from(sizes.sum::<u32>());
    }
    Ok(observed)
}

/// Proves what can be proven of the functions of `monitor-core`.
///
/// # Errors
/// See [`taint::prove`].
pub fn prove(kernels: &Kernels, questions: &[Question]) -> Result<BTreeMap<&'static str, Proof>, String> {
    let requests: Vec<_> = questions.iter().map(|question| (question.request, question.label)).collect();
    taint::prove(&kernels.elf, &kernels.image, &kernels.code, &requests)
}

/// Traces, models and proves everything.
///
/// # Errors
/// The audit cannot be made, and what helps.
pub fn report(kernels: &Kernels, progress: &mut dyn FnMut(&str)) -> Result<Report, String> {
    progress("tracing every function of the monitor and its peers, instruction by instruction");
    let Runs { observed, of_peers } = trace_all(kernels)?;
    progress("proving that paths do not depend on data");
    let short =
        [inputs::steps(1, 120), inputs::guard(1, 200), inputs::windows(1, 40), inputs::functions(Some(24))].concat();
    let proofs = prove(kernels, &short)?;
    let mut report = Report { title: "time".to_owned(), blind_spots: BLIND_SPOTS.into(), ..Report::default() };
    report.tables = vec![table(&observed, &proofs), of_peers_table(&of_peers), proof_table(&proofs)];
    if !kernels.with_c {
        report.notes.push(
            "peers in C are missing: arm-none-eabi-gcc is not installed (apt-get install gcc-arm-none-eabi)".into(),
        );
    }
    for (label, row) in &observed {
        report.figures.extend(figures(label, row, proofs.get(label)));
    }
    for label in PROVEN {
        let faults = proofs.get(label).map_or_else(|| vec!["no call was followed".to_owned()], Proof::faults);
        report.faults.extend(faults.iter().map(|fault| format!("{label} takes more than one path: {fault}")));
    }
    report.faults.extend(several_paths(&observed));
    report.faults.extend(forbidden_at_start_up(kernels)?);
    for (label, proof) in
        proofs.iter().filter(|(label, proof)| !label.is_empty() && !PROVEN.contains(label) && !proof.holds())
    {
        let faults = proof.faults();
        let shown = faults.get(..faults.len().min(SHOWN)).unwrap_or_default().join("; ");
        report.notes.push(format!("{label} depends on data in {} places: {shown}", faults.len()));
    }
    Ok(report)
}

/// Decisions by data that are quoted for a function that need not be free of them.
const SHOWN: usize = 3;

struct Runs {
    observed: BTreeMap<&'static str, Observed>,
    of_peers: BTreeMap<&'static str, Observed>,
}

/// Two emulators side by side: the ends of windows take as long as everything else.
fn trace_all(kernels: &Kernels) -> Result<Runs, String> {
    let (windows, rest, of_peers) = std::thread::scope(|scope| {
        let windows = scope.spawn(|| observe(kernels, &[inputs::windows(40, 26), inputs::guard(5, 2100)].concat()));
        let rest = observe(kernels, &[inputs::steps(12, 480), inputs::functions(None), inputs::start_up()].concat());
        let of_peers = observe(kernels, &inputs::peers(kernels.with_c));
        (windows.join().unwrap_or_else(|_| Err("the tracer has failed".to_owned())), rest, of_peers)
    });
    let mut observed = rest?;
    observed.extend(windows?);
    Ok(Runs { observed, of_peers: of_peers? })
}

/// Routine slots take one path each, and judging takes the same one whether or not a relay switches.
fn several_paths(observed: &BTreeMap<&'static str, Observed>) -> Vec<String> {
    let paths = |labels: &[&str]| {
        let all = labels.iter().filter_map(|label| observed.get(label)).flat_map(|row| row.paths.iter());
        all.collect::<BTreeSet<_>>().len()
    };
    let routines: [&[&str]; 2] = [&[inputs::MONITORING, inputs::SWITCHING], &[inputs::LEARNING]];
    let several = routines.into_iter().filter(|labels| paths(labels) != 1);
    several.map(|labels| format!("{} took {} paths, and not one", labels.join(" and "), paths(labels))).collect()
}

/// What the functions of start-up reach and must not, each a sentence: double precision, panic, heap, and so on.
fn forbidden_at_start_up(kernels: &Kernels) -> Result<Vec<String>, String> {
    let entries = inputs::AT_START_UP.map(|function| function.kernel.symbol());
    let graph = Graph::new(&kernels.image, &kernels.code)?.entered_by(&entries)?;
    let found = forbidden::findings(&kernels.image, &graph, false);
    Ok(found.iter().map(|finding| format!("start-up: {}", finding.sentence())).collect())
}

fn figures(label: &str, row: &Observed, proof: Option<&Proof>) -> Vec<Figure> {
    let figure = |what: &str, value, unit| Figure { name: format!("time.{label}.{what}"), value, unit };
    let mut figures = vec![
        figure("instructions", row.largest(|cost| cost.instructions), "instructions"),
        figure("worst", row.largest(|cost| cost.worst), "cycles"),
    ];
    // What runs once may branch on its arguments: the number of its paths says how many arguments were tried.
    if !inputs::AT_START_UP.iter().any(|function| function.label == label) {
        figures.push(figure("paths", row.paths.len() as u64, "paths"));
    }
    figures.extend(proof.map(|proof| figure("decisions_by_data", proof.violations.len() as u64, "decisions")));
    figures
}

const COLUMNS: [&str; 10] =
    ["", "inputs", "instructions", "paths", "best", "nominal", "worst", "% at 1 kHz", "% at 10 kHz", "code"];

fn row(label: &str, seen: &Observed) -> Vec<String> {
    let all = seen.instructions();
    let (least, most) = (all.first().copied().unwrap_or_default(), all.last().copied().unwrap_or_default());
    let median = all.get(all.len() / 2).copied().unwrap_or_default();
    let instructions = if least == most { most.to_string() } else { format!("{least} {median} {most}") };
    let best = seen.costs.iter().map(|cost| cost.best).min().unwrap_or_default();
    let worst = seen.largest(|cost| cost.worst);
    let percent = RATES_HZ.map(|rate| format!("{:.2}", 100.0 * worst as f64 * rate / CORE_HZ));
    let [slow, fast] = percent;
    let nominal = seen.largest(|cost| cost.nominal);
    let numbers = [seen.calls, seen.paths.len() as u64, best, nominal, worst, seen.bytes].map(|n| n.to_string());
    let [calls, paths, best, nominal, worst, bytes] = numbers;
    vec![label.to_owned(), calls, instructions, paths, best, nominal, worst, slow, fast, bytes]
}

fn table(observed: &BTreeMap<&'static str, Observed>, proofs: &BTreeMap<&'static str, Proof>) -> Table {
    let mut header = COLUMNS.to_vec();
    header.push("proof");
    let caption = "The monitor on a Cortex-M4F: instructions (least, median, most), cycles by the model, % of a 168 MHz core \
                   at worst, bytes of code";
    let mut table = Table::new(caption, &header);
    for (label, seen) in observed {
        let mut cells = row(label, seen);
        cells.push(match proofs.get(label) {
            Some(proof) if proof.holds() => "one path".to_owned(),
            Some(proof) => format!("{} decisions", proof.violations.len()),
            None => "none".to_owned(),
        });
        table.rows.push(cells);
    }
    table
}

fn of_peers_table(observed: &BTreeMap<&'static str, Observed>) -> Table {
    let mut table = Table::new("Peers on the same processor and inputs (solvers: finite matrices only)", &COLUMNS);
    table.rows.extend(observed.iter().map(|(label, seen)| row(label, seen)));
    table
}

fn proof_table(proofs: &BTreeMap<&'static str, Proof>) -> Table {
    let header = ["", "calls", "instructions", "selects", "decisions by data", "state that decides", "of it the phase"];
    let mut table = Table::new("Marks followed: what a path depends on, bytes of state", &header);
    for (label, proof) in proofs.iter().filter(|(label, _)| !label.is_empty()) {
        let numbers = [
            proof.calls,
            proof.instructions,
            proof.selects.len() as u64,
            proof.violations.len() as u64,
            proof.control.len() as u64,
            proof.phase.len() as u64,
        ];
        let mut cells = vec![(*label).to_owned()];
        cells.extend(numbers.map(|number| number.to_string()));
        table.rows.push(cells);
    }
    table
}
