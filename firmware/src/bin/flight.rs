//! The flight image for the STM32F405. On a host it prints the configuration that is compiled in.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    use estimator_core::Config;
    use firmware::parameters::PARAMETERS;

    let rows = PARAMETERS.iter().map(|parameter| {
        let (name, unit, [low, high]) = (parameter.name, parameter.unit, parameter.range);
        let value = parameter.value(&Config::default());
        format!("  \"{name}\": {{ \"unit\": \"{unit}\", \"value\": {value}, \"range\": [{low}, {high}] }}")
    });
    println!("{{\n{}\n}}", rows.collect::<Vec<_>>().join(",\n"));
}

#[cfg(target_os = "none")]
#[path = "../board/mod.rs"]
mod board;

#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use firmware::watch::Watch;
    use heapless::spsc::{Producer, Queue};

    use crate::board::control::{Control, Desk, Report, Test};
    use crate::board::link::Link;
    use crate::board::uart::Uart;
    use crate::board::{self, Parts};

    #[shared]
    struct Shared {
        test: Test,
        desk: Desk,
    }

    #[local]
    struct Local {
        control: Control,
        reports: Producer<'static, Report>,
        uart: Uart,
        link: Link,
    }

    #[init(local = [
        report_queue: Queue<Report, 4> = Queue::new(),
        receive_queue: Queue<u8, 1024> = Queue::new(),
        send_queue: Queue<u8, 3072> = Queue::new(),
        watch: Option<Watch> = None,
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (reports, reported) = cx.local.report_queue.split();
        let (received, incoming) = cx.local.receive_queue.split();
        let (outgoing, sending) = cx.local.send_queue.split();
        let Parts { control, tx, rx, cause, clock_hz, memory } = board::start(cx.device, cx.core);
        let uart = Uart { tx, rx, received, sending };
        let link = Link::new(incoming, outgoing, reported, control.sensors(), cause, clock_hz, memory);
        let test = link.test(cx.local.watch.insert(Watch::default()));
        (Shared { test, desk: Desk::default() }, Local { control, reports, uart, link })
    }

    /// The control cycle. Nothing is above it.
    #[task(binds = TIM2, priority = 3, local = [control, reports], shared = [test, desk])]
    fn cycle(cx: cycle::Context) {
        let cycle::LocalResources { control, reports, .. } = cx.local;
        (cx.shared.test, cx.shared.desk).lock(|test, desk| control.step(test, desk, reports));
    }

    #[task(binds = PVD, priority = 3)]
    fn brown_out(_: brown_out::Context) {
        board::failsafe::brown_out();
    }

    #[task(binds = USART2, priority = 2, local = [uart])]
    fn serial(cx: serial::Context) {
        cx.local.uart.serve();
    }

    #[idle(local = [link], shared = [test, desk])]
    fn idle(cx: idle::Context) -> ! {
        let idle::SharedResources { mut test, mut desk, .. } = cx.shared;
        let link = cx.local.link;
        link.recall();
        link.greet();
        loop {
            while let Some(action) = link.listen() {
                (&mut test, &mut desk).lock(|test, desk| link.act(action, test, desk));
            }
            link.tell(|| test.lock(|test| *test.state.taps()));
            // asleep until the next interrupt; with interrupts held back none is missed between look and sleep
            cortex_m::interrupt::free(|_| {
                if link.quiet() {
                    cortex_m::asm::wfi();
                }
            });
        }
    }
}
