//! Names of symbols: demangled for people, and the crate that a symbol belongs to.

/// The name people read, without hashes.
#[must_use]
pub fn demangled(linkage_name: &str) -> String {
    // LTO appends `.llvm.<hash>` to what it had to rename.
    let name = linkage_name.split(".llvm.").next().unwrap_or(linkage_name);
    format!("{:#}", rustc_demangle::demangle(name))
}

/// The crate that defines a mangled Rust symbol; none for other names.
///
/// Of an implementation it is the crate that wrote it, not that of the type: `<nalgebra::Matrix as
/// monitor_core::ClosedFormEigen>::f` belongs to `monitor_core`.
#[must_use]
pub fn crate_of(linkage_name: &str) -> Option<String> {
    // A table that the compiler made of a `match` carries the function's name.
    let name = linkage_name.strip_prefix(".Lswitch.table.").unwrap_or(linkage_name);
    if let Some(path) = name.strip_prefix("_R") {
        return first_crate_root(path).or_else(|| first_path(&demangled(name)));
    }
    name.starts_with("_ZN").then(|| first_path(&demangled(name))).flatten()
}

/// The crate of a compilation unit's name, such as `monitor_core.5927d698780554d7-cgu.0`.
#[must_use]
pub(super) fn crate_of_unit(unit: &str) -> String {
    unit.split(['.', '-']).next().unwrap_or(unit).to_owned()
}

/// The crate in which the first path of a v0 symbol is rooted (Rust RFC 2603): for an implementation that is the path
/// of the `impl` block.
fn first_crate_root(path: &str) -> Option<String> {
    let mut rest = path;
    loop {
        let (tag, behind) = rest.split_at_checked(1)?;
        rest = match tag {
            "N" => behind.get(1..)?,
            "I" => behind,
            "M" | "X" => without_disambiguator(behind)?,
            "C" => return identifier(without_disambiguator(behind)?).map(str::to_owned),
            _ => return None,
        };
    }
}

/// Skips `s<base 62>_`, if it is there.
fn without_disambiguator(text: &str) -> Option<&str> {
    match text.strip_prefix('s') {
        Some(number) => number.split_once('_').map(|(_, rest)| rest),
        None => Some(text),
    }
}

/// Reads `<length>[_]<name>`.
fn identifier(text: &str) -> Option<&str> {
    let digits = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let (length, name) = text.split_at_checked(digits)?;
    name.strip_prefix('_').unwrap_or(name).get(..length.parse().ok()?)
}

/// The crate at the start of a demangled path, looking into `<T as Trait>`.
fn first_path(demangled: &str) -> Option<String> {
    let mut candidates = demangled.trim_start_matches(['<', '&', '*', '(', '[']).split(" as ");
    candidates.find_map(|path| {
        let root = path.trim_start_matches(['<', '&']).split_once("::")?.0;
        root.chars().all(|c| c.is_alphanumeric() || c == '_').then(|| root.to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symbol_belongs_to_the_crate_that_wrote_the_function() {
        for (name, owner) in [
            ("_RNvMs3_NtCs5lOfwTpqklZ_12monitor_core7monitorNtB5_7Monitor3new", Some("monitor_core")),
            ("_RNvCs47oie2rruF1_12qemu_mission18___cortex_m_rt_main", Some("qemu_mission")),
            ("_ZN12monitor_core7monitor7Monitor3new17h0123456789abcdefE", Some("monitor_core")),
            ("_ZN45_$LT$f32$u20$as$u20$defmt..traits..Format$GT$3fmt17h0123456789abcdefE", Some("defmt")),
            (".Lswitch.table._RNvNtCs68SINNLm4Xf_13firmware_stub6report5event.32", Some("firmware_stub")),
            ("__aeabi_memcpy", None),
            ("_Reset", None),
            ("_RX", None),
        ] {
            assert_eq!(crate_of(name).as_deref(), owner, "{name}");
        }
    }

    #[test]
    fn a_compilation_unit_is_named_after_its_crate() {
        assert_eq!(crate_of_unit("monitor_core.5927d698780554d7-cgu.0"), "monitor_core");
    }
}
