//! A flash that waits, for code that would rather await: `sequential-storage` is asynchronous,
//! drivers of an internal flash are not.
//!
//! Nothing in such a flash ever returns `Pending`, so that a future over it is ready when it is
//! polled for the first time: [`ready`] is the whole executor, and needs no bound.

use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use embedded_storage_async::nor_flash as asynchronous;

/// A flash behind the asynchronous traits.
pub struct Blocking<'a, F> {
    flash: &'a mut F,
    may_change: bool,
}

impl<'a, F> Blocking<'a, F> {
    /// A flash to be read. What would repair it, an erasure, is left undone.
    pub const fn to_read(flash: &'a mut F) -> Self {
        Self { flash, may_change: false }
    }

    /// A flash to be read and changed.
    pub const fn to_change(flash: &'a mut F) -> Self {
        Self { flash, may_change: true }
    }
}

impl<F: ErrorType> ErrorType for Blocking<'_, F> {
    type Error = F::Error;
}

impl<F: ReadNorFlash> asynchronous::ReadNorFlash for Blocking<'_, F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.flash.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl<F: NorFlash> asynchronous::NorFlash for Blocking<'_, F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        if self.may_change { self.flash.erase(from, to) } else { Ok(()) }
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        if self.may_change { self.flash.write(offset, bytes) } else { Ok(()) }
    }
}

/// Polls a future once; `None` if it is not ready, which one over [`Blocking`] always is.
pub fn ready<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => Some(output),
        Poll::Pending => None,
    }
}
