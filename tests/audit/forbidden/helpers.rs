//! Names of functions that are there for one purpose.
//!
//! Sources: the run-time ABI for the Arm architecture (Arm IHI 0043, chapter 5), the list of libgcc's soft-float library,
//! and the language items of Rust's `core`.

/// An allocator, or the crate that wants one.
pub(super) fn is_heap(name: &str) -> bool {
    let c = ["malloc", "calloc", "realloc", "free", "_sbrk", "sbrk"].contains(&name);
    let shims = ["__rust_alloc", "__rust_realloc", "__rust_dealloc", "__rg_alloc", "__rg_realloc", "__rg_dealloc"];
    let shim = shims.iter().any(|shim| name.contains(shim));
    c || shim || name.contains("GlobalAlloc>::") || begins(name, "alloc::")
}

/// A panic handler or a function of `core` that ends in one.
pub(super) fn is_panic(name: &str) -> bool {
    let ends = [
        "_fail",
        "_fail_rt",
        "unwrap_failed",
        "expect_failed",
        "rust_begin_unwind",
        "len_mismatch_fail",
        "handle_error",
    ];
    begins(name, "core::panicking::")
        || name.contains("panic_already_")
        || (begins(name, "core::") || begins(name, "alloc::") || begins(name, "__rustc::"))
            && ends.iter().any(|end| name.ends_with(end))
}

/// A double-precision helper, conversions from and to it included.
pub(super) fn is_soft_double(name: &str) -> bool {
    let helper = last(name);
    let aeabi = helper.strip_prefix("__aeabi_").is_some_and(|rest| {
        let converts = ["f2d", "i2d", "ui2d", "l2d", "ul2d", "h2d"].contains(&rest);
        // `d` and an operation; `cd` and a compare.
        converts || rest.starts_with("cd") || rest.strip_prefix('d').is_some_and(|operation| !operation.is_empty())
    });
    aeabi || libgcc(helper, "df", &["__truncdfsf2", "__extendsfdf2", "__extendhfdf2", "__powidf2"])
}

/// A single-precision helper.
pub(super) fn is_soft_float(name: &str) -> bool {
    let helper = last(name);
    let aeabi = helper.strip_prefix("__aeabi_").is_some_and(|rest| {
        let converts = ["i2f", "ui2f", "l2f", "ul2f"].contains(&rest);
        converts
            || rest.starts_with("cf")
            || rest != "f2d" && rest.strip_prefix('f').is_some_and(|operation| !operation.is_empty())
    });
    aeabi || libgcc(helper, "sf", &["__powisf2"])
}

/// Whether a name is one of libgcc's `__<operation><mode>[2|3]`, `__fix..<mode>..` or `__float..<mode>`, or among `more`.
fn libgcc(helper: &str, mode: &str, more: &[&str]) -> bool {
    let operations = ["add", "sub", "mul", "div", "neg", "eq", "ne", "lt", "le", "gt", "ge", "cmp", "unord"];
    let operates = operations.iter().any(|operation| {
        let rest = helper.strip_prefix("__").and_then(|rest| rest.strip_prefix(operation));
        rest.and_then(|rest| rest.strip_prefix(mode)).is_some_and(|arity| ["2", "3", "3vfp", "2vfp"].contains(&arity))
    });
    let to_integer = helper.strip_prefix("__fix").is_some_and(|rest| rest.trim_start_matches("uns").starts_with(mode));
    let from_integer = helper.starts_with("__float") && helper.ends_with(mode);
    operates || to_integer || from_integer || more.contains(&helper)
}

/// The last part of a path: `compiler_builtins::float::add::__adddf3` is `__adddf3`.
fn last(name: &str) -> &str {
    name.rsplit("::").next().unwrap_or(name)
}

/// Whether a path begins with a crate or module, also inside `<T as Trait>`.
fn begins(name: &str, module: &str) -> bool {
    name.trim_start_matches(['<', '&', '*', '[', '(']).starts_with(module)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_purpose_knows_its_names_and_no_others() {
        let doubles = [
            "__aeabi_dmul",
            "__aeabi_f2d",
            "__aeabi_cdcmple",
            "compiler_builtins::float::mul::__muldf3",
            "__fixunsdfsi",
            "__floatsidf",
            "__truncdfsf2",
        ];
        let floats =
            ["__aeabi_fmul", "__aeabi_f2iz", "__aeabi_cfcmple", "__aeabi_l2f", "__mulsf3", "__fixsfdi", "__floatdisf"];
        let panics = [
            "core::panicking::panic_bounds_check",
            "core::option::unwrap_failed",
            "core::slice::index::slice_index_fail",
            "__rustc::rust_begin_unwind",
        ];
        let heaps = [
            "__rustc::__rust_alloc",
            "malloc",
            "alloc::raw_vec::RawVec::grow_one",
            "<app::Bump as core::alloc::global::GlobalAlloc>::alloc",
            "<x as core::alloc::GlobalAlloc>::alloc",
        ];
        let innocent = [
            "__aeabi_memcpy",
            "__aeabi_uldivmod",
            "monitor_core::paper::monitor::Monitor::step",
            "main",
            "__aeabi_llsl",
            "core::fmt::write",
        ];
        let purposes = [is_soft_double, is_soft_float, is_panic, is_heap];
        let names: [&[&str]; 4] = [&doubles, &floats, &panics, &heaps];
        for (purpose, own) in purposes.into_iter().zip(names) {
            for name in [&doubles[..], &floats, &panics, &heaps, &innocent].concat() {
                assert_eq!(purpose(name), own.contains(&name), "{name}");
            }
        }
    }
}
