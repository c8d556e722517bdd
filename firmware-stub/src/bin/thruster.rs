//! The thruster controller's firmware: the monitor under RTIC on an STM32F405, in `guard` mode, or in `paper` mode with the
//! feature `paper`.
//!
//! TIM2 samples at 1 kHz; USART3 takes the bytes of requests; idle learns, logs, asks for names, answers, and feeds the watchdog
//! while the sampling interrupt is alive. Everything that computes is `monitor-core`; this is wiring.

#![no_std]
#![no_main]
#![allow(unsafe_code, missing_docs, unreachable_pub)] // What `rtic::app` writes has some.

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use firmware_stub::background::{Answer, Background};
    use firmware_stub::board::stm32f405::{
        self, Clock, Converter, Encoder, FaultOutput, SamplingTimer, SerialLine, TICKS_PER_SECOND,
    };
    use firmware_stub::deadline::Deadline;
    use firmware_stub::fault::Reason;
    use firmware_stub::report::{self, Report};
    use firmware_stub::request::Requests;
    use firmware_stub::sampling::{Notes, Reading, Sampling};
    use firmware_stub::settings::{Flown, SAMPLE_RATE_HZ, WATCHDOG_MS, flown};
    use firmware_stub::{board, scale};
    use heapless::spsc::{Consumer, Producer, Queue};
    use monitor_core::sample::Absence;
    use monitor_core::units::RadPerSec;
    use monitor_core::{Ranges, Sample};
    use stm32f4xx_hal::prelude::*;
    use stm32f4xx_hal::watchdog::IndependentWatchdog;

    /// Bytes of requests between two turns.
    const BYTES: usize = 16;
    /// Ticks in one slot; a reading in its second half is late.
    const PERIOD: u32 = SamplingTimer::period(SAMPLE_RATE_HZ);

    #[shared]
    struct Shared {
        sampling: Sampling<'static, Flown>,
        set_point: RadPerSec,
    }

    #[local]
    struct Local {
        timer: SamplingTimer,
        clock: Clock,
        deadline: Deadline,
        encoder: Encoder,
        converter: Converter,
        ranges: Ranges,
        output: FaultOutput,
        line: SerialLine,
        sent: Producer<'static, u8, BYTES>,
        received: Consumer<'static, u8, BYTES>,
        background: Background<'static, Flown>,
        report: Report<Flown>,
        watchdog: IndependentWatchdog,
    }

    #[init(local = [notes: Notes<Flown> = Queue::new(), bytes: Queue<u8, BYTES> = Queue::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let chip = cx.device;
        stm32f405::start_clocks(&chip.RCC, &chip.FLASH);
        if let Some(reason) = stm32f405::last_reason(&chip.RCC) {
            report::last_run(reason);
        }
        let mut rcc = chip.RCC.constrain();
        let (b, c) = (chip.GPIOB.split(&mut rcc), chip.GPIOC.split(&mut rcc));
        let output = FaultOutput::safe(b.pb0, b.pb1);
        let _encoder = (b.pb6.into_alternate::<2>(), b.pb7.into_alternate::<2>());
        let _line = (b.pb10.into_alternate::<7>(), b.pb11.into_alternate::<7>());
        let _analogue = (c.pc0.into_analog(), c.pc1.into_analog());

        let (Ok(monitor), Ok(ranges)) = (flown(), scale::ranges()) else { board::stop(Reason::Settings) };
        let (notes, heard) = cx.local.notes.split();
        let (sent, received) = cx.local.bytes.split();
        let mut watchdog = IndependentWatchdog::new(chip.IWDG);
        watchdog.start(WATCHDOG_MS.millis());
        let clock = Clock::start(chip.TIM5);
        let shared = Shared { sampling: Sampling::new(monitor, notes), set_point: RadPerSec(0.0) };
        let local = Local {
            encoder: Encoder::start(chip.TIM4, SAMPLE_RATE_HZ),
            converter: Converter::start(chip.ADC1, &chip.ADC_COMMON),
            ranges,
            output,
            line: SerialLine::start(chip.USART3),
            sent,
            received,
            background: Background::new(heard),
            report: Report::new(SAMPLE_RATE_HZ),
            watchdog,
            deadline: Deadline::new(PERIOD, PERIOD / 2),
            timer: SamplingTimer::start(chip.TIM2, SAMPLE_RATE_HZ),
            clock,
        };
        defmt::println!("sampling at {=u32} Hz, clock of {=u32} Hz", SAMPLE_RATE_HZ, TICKS_PER_SECOND);
        (shared, local)
    }

    #[task(binds = TIM2, priority = 3, shared = [sampling, set_point],
           local = [timer, clock, deadline, encoder, converter, ranges, output])]
    fn sample(cx: sample::Context) {
        let sample::LocalResources { timer, clock, deadline, encoder, converter, ranges, output, .. } = cx.local;
        timer.acknowledge();
        let slot = deadline.enter(clock.now());
        let read = || match (encoder.speed(), converter.read()) {
            (speed, Some((armature_current, armature_voltage))) => {
                Reading::Taken(ranges.admit(Sample { speed, armature_current, armature_voltage }))
            }
            (_, None) => Reading::Absent(Absence::Missing),
        };
        (cx.shared.sampling, cx.shared.set_point).lock(|sampling, set_point| {
            sampling.on_interrupt(slot, *set_point, read, |fault| output.set(fault));
            if deadline.overrun(clock.now()) {
                sampling.overran();
            }
        });
    }

    /// A byte of a request. One that finds the queue full is lost, and whoever sent it asks again. Above the sampling interrupt, and
    /// so above whoever holds that off: a byte must be fetched within 1,389 cycles at 16 MHz, and copying the monitor takes longer.
    #[task(binds = USART3, priority = 4, local = [line, sent])]
    fn request(cx: request::Context) {
        if let Some(byte) = cx.local.line.byte() {
            let _ = cx.local.sent.enqueue(byte);
        }
    }

    #[idle(shared = [sampling, set_point], local = [received, background, report, watchdog])]
    fn idle(cx: idle::Context) -> ! {
        let idle::LocalResources { received, background, report, watchdog, .. } = cx.local;
        let (mut sampling, mut set_point) = (Locked(cx.shared.sampling), cx.shared.set_point);
        let mut requests = Requests::default();
        loop {
            if let Some(learned) = background.learn(&mut sampling) {
                report.learned(learned, background.in_vain());
            }
            while let Some(note) = background.next_note() {
                report.note(note);
            }
            if let Some(named) = background.name(&mut sampling) {
                report.named(&named);
            }
            while let Some(request) = received.dequeue().map(|byte| requests.byte(byte)) {
                let Some(request) = request else { continue };
                let answer = background.answer(request, &mut sampling);
                if let Answer::SetPoint(new) = answer {
                    set_point.lock(|set_point| *set_point = new);
                }
                report.answer(&answer);
            }
            if background.sampling_is_alive(&mut sampling) {
                watchdog.feed();
            }
            board::wait();
        }
    }

    /// RTIC's lock as the main loop's access to what the interrupt owns.
    struct Locked<M>(M);

    impl<M: rtic::Mutex<T = Sampling<'static, Flown>>> firmware_stub::Shared<'static, Flown> for Locked<M> {
        fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'static, Flown>) -> R) -> R {
            self.0.lock(f)
        }
    }
}
