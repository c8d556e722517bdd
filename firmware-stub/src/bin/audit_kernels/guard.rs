//! The functions of `guard` mode that are audited.

#![allow(unsafe_code)] // Unmangled names, which the host looks for; nothing else has them.

use core::mem::MaybeUninit;

use firmware_stub::kernels::guard as given;
use firmware_stub::kernels::{Kernel, Request};
use monitor_core::guard::{Directions, Finding, Model, Monitor, Quality};
use monitor_core::moments::LearnError;

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_guard_finish_learning(guard: &mut Monitor) -> bool {
    guard.finish_learning().is_ok()
}

#[inline(never)]
#[unsafe(no_mangle)]
fn audit_guard_finding(guard: &Monitor, directions: &Directions) -> Finding {
    guard.finding(directions)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_guard_copy(copy: &mut MaybeUninit<Monitor>, guard: &Monitor) {
    copy.write(guard.clone());
}

#[inline(never)]
#[unsafe(no_mangle)]
fn audit_guard_install(guard: &mut Monitor, model: Result<(Model, Quality), LearnError>) -> bool {
    guard.install(model)
}

/// A monitor in `guard` mode, and the faults it knows.
pub(crate) struct Guarding {
    guard: Monitor,
    directions: Directions,
}

impl Guarding {
    pub(crate) fn new() -> Option<Self> {
        Some(Guarding { guard: Monitor::new(&given::config()).ok()?, directions: given::directions() })
    }

    /// Calls a kernel; returns the digest of its result.
    pub(crate) fn call(&mut self, request: &Request) -> u32 {
        let [set_point, a, b, c, ..] = request.numbers();
        match request.kernel {
            Kernel::GuardStep => given::digest_of_verdict(self.guard.step_channels(set_point, [a, b, c])),
            Kernel::GuardFinishLearning => u32::from(audit_guard_finish_learning(&mut self.guard)),
            Kernel::GuardCopy => {
                let mut copy = MaybeUninit::uninit();
                audit_guard_copy(&mut copy, &self.guard);
                // SAFETY: the function above has written it.
                given::digest_of_verdict(unsafe { copy.assume_init_ref() }.verdict())
            }
            Kernel::GuardInstall => {
                let mut copy = self.guard.clone();
                let Some(window) = copy.learned() else { return 0 };
                let model = Model::learn(window, copy.design());
                u32::from(audit_guard_install(&mut copy, model))
            }
            _ => given::digest_of_finding(&audit_guard_finding(&self.guard, &self.directions)),
        }
    }
}
