//! Bytes between USART2 and the queues of the link.

use heapless::spsc::{Consumer, Producer};
use stm32f4xx_hal::pac::USART2;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::serial::{Rx, RxISR, Tx, TxISR};

/// Both directions.
pub struct Uart {
    pub tx: Tx<USART2>,
    pub rx: Rx<USART2>,
    pub received: Producer<'static, u8>,
    pub sending: Consumer<'static, u8>,
}

impl Uart {
    /// Serves the interrupt. A byte for which there is no room is dropped; the checksum of its frame tells.
    pub fn serve(&mut self) {
        while self.rx.is_rx_not_empty() {
            // an overrun or a framing error costs its byte
            let Ok(byte) = embedded_hal_nb::serial::Read::read(&mut self.rx) else { break };
            let _ = self.received.enqueue(byte);
        }
        // a real transmitter takes two bytes and asks again; the emulated one takes all, and never asks
        while self.tx.is_tx_empty() {
            let Some(byte) = self.sending.dequeue() else { return self.tx.unlisten() };
            let _ = embedded_hal_nb::serial::Write::write(&mut self.tx, byte);
        }
        self.tx.listen();
    }
}
