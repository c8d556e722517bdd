//! A mission on the emulated board: every slot of the host's stream goes through the sampling interrupt. That is PendSV, pended
//! once for each; it judges at once, since its priority is above the main loop's.

use core::cell::RefCell;

use cortex_m::peripheral::SCB;
use critical_section::Mutex;

use super::FaultOutput;
use crate::background::{Background, Shared};
use crate::board;
use crate::board::exchange::{Answered, Refusal};
use crate::deadline::Slot;
use crate::fault::Reason;
use crate::record::{Arrival, SLOT_WORDS};
use crate::report::{Report, Spoken};
use crate::sampling::{Notes, Sampling};

/// What the interrupt owns: its state, the output it drives, and what the host sent for the slot that is due.
struct Owned<M: Spoken + 'static> {
    sampling: Sampling<'static, M>,
    output: FaultOutput,
    arrival: Option<Arrival>,
}

/// The place of what the interrupt owns.
pub struct Interrupt<M: Spoken + 'static>(Mutex<RefCell<Option<Owned<M>>>>);

impl<M: Spoken> Interrupt<M> {
    /// An interrupt that samples nothing yet.
    #[must_use]
    #[allow(clippy::new_without_default)] // It stands in a static.
    pub const fn new() -> Self {
        Interrupt(Mutex::new(RefCell::new(None)))
    }

    /// The sampling interrupt.
    pub fn sample(&self) {
        critical_section::with(|cs| {
            let Ok(mut owned) = self.0.borrow(cs).try_borrow_mut() else { return };
            let Some(Owned { sampling, output, arrival }) = owned.as_mut() else { return };
            let Some(arrival) = arrival.take() else { return };
            sampling.on_interrupt(Slot::default(), arrival.set_point, || arrival.reading, |fault| output.set(fault));
        });
    }

    /// Calls `f` with the interrupt held off.
    fn held_off<R>(&self, f: impl FnOnce(&mut Owned<M>) -> R) -> R {
        critical_section::with(|cs| match self.0.borrow(cs).try_borrow_mut().as_deref_mut() {
            Ok(Some(owned)) => f(owned),
            _ => board::stop(Reason::Settings),
        })
    }
}

impl<M: Spoken> Shared<'static, M> for &'static Interrupt<M> {
    fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'static, M>) -> R) -> R {
        self.held_off(|owned| f(&mut owned.sampling))
    }
}

/// The main loop of a mission.
pub struct Flight<M: Spoken + 'static> {
    interrupt: &'static Interrupt<M>,
    background: Background<'static, M>,
    report: Report<M>,
}

impl<M: Spoken> Flight<M> {
    /// Of a monitor before its first slot.
    pub fn new(interrupt: &'static Interrupt<M>, mode: M, queue: &'static mut Notes<M>, sample_rate_hz: f32) -> Self {
        let (notes, heard) = queue.split();
        let owned = Owned { sampling: Sampling::new(mode, notes), output: FaultOutput::safe(), arrival: None };
        critical_section::with(|cs| interrupt.0.borrow(cs).replace(Some(owned)));
        Flight { interrupt, background: Background::new(heard), report: Report::new(sample_rate_hz as u32) }
    }

    /// One slot: the interrupt judges it, `answer` says what the host is told of that, the rest is done at leisure.
    ///
    /// # Errors
    /// A sentence for the host.
    pub fn turn<const N: usize>(
        &mut self,
        words: [u32; SLOT_WORDS],
        answer: impl FnOnce(&M) -> [u32; N],
    ) -> Answered<N> {
        let arrival = Arrival::from_words(words).ok_or(&b"error: a record of the stream is not a slot\n\0"[..])?;
        let Flight { interrupt, background, report } = self;
        interrupt.held_off(|owned| owned.arrival = Some(arrival));
        SCB::set_pendsv();
        cortex_m::asm::isb();
        let judged = interrupt.held_off(|owned| owned.arrival.is_none().then(|| answer(owned.sampling.mode())));
        let judged = judged.ok_or::<Refusal>(b"error: the sampling interrupt did not come\n\0")?;
        if let Some(learned) = background.learn(interrupt) {
            report.learned(learned, background.in_vain());
        }
        while let Some(note) = background.next_note() {
            report.note(note);
        }
        if let Some(named) = background.name(interrupt) {
            report.named(&named);
        }
        if let Some(request) = arrival.request {
            report.answer(&background.answer(request, interrupt));
        }
        Ok(judged)
    }
}
