//! The key page in flash, and nonces for chips without a random number generator.

#[cfg(feature = "netduinoplus2")]
use core::mem::MaybeUninit;
#[cfg(feature = "netduinoplus2")]
use core::sync::atomic::{AtomicU32, Ordering};
#[cfg(feature = "netduinoplus2")]
use firmware::board::Nonces;
use link::Access;
use link::key_page::{self, KeyPage};
#[cfg(feature = "netduinoplus2")]
use link::{Key, Nonce, NonceSource};

#[allow(unsafe_code, reason = "an address from the linker script")]
// SAFETY: `memory.x` puts the symbol at a separate flash region, which is longer than this array.
unsafe extern "C" {
    /// The key page in flash (`memory.x`).
    #[link_name = "_key_page"]
    static PAGE: [u8; key_page::LENGTH];
}

fn page() -> Option<KeyPage<'static>> {
    #[allow(unsafe_code, reason = "flash at an address that the linker script keeps free of the program")]
    // SAFETY: readable memory of this length, which nothing writes while the program runs.
    let page: &'static [u8; key_page::LENGTH] = unsafe { &PAGE };
    KeyPage::read(page)
}

/// The hosts that this board accepts.
pub(crate) fn access() -> Access {
    if cfg!(feature = "insecure") {
        return Access::Insecure;
    }
    page().map_or(Access::NoKey, |page| Access::Key(page.key()))
}

/// Nonces from the random number stored with the key, a count that survives a reset, and a timer. No nonce is repeated while the power stays on.
/// After power-off, a nonce is repeated only with the same number, the same count and the same reading of the timer.
#[cfg(feature = "netduinoplus2")]
pub struct CountedNonces<F>(pub F);

#[cfg(feature = "netduinoplus2")]
impl<F: Fn() -> u32> Nonces for CountedNonces<F> {
    fn next(&mut self) -> Option<(Nonce, NonceSource)> {
        /// Not initialised at the start: it continues from its previous value, or from an arbitrary one.
        #[allow(unsafe_code, reason = "a section of the start-up code's that it leaves alone")]
        #[unsafe(link_section = ".uninit.nonces")]
        static COUNT: MaybeUninit<AtomicU32> = MaybeUninit::uninit();
        #[allow(unsafe_code, reason = "memory that the start-up code leaves alone")]
        // SAFETY: any bit pattern is a valid number, and the memory is accessed only through this reference.
        let count = unsafe { COUNT.assume_init_ref() };
        let count = count.fetch_add(1, Ordering::Relaxed).wrapping_add(1);
        let page = page()?;
        Some((Key::new(*page.key()).nonce(page.seed, count, (self.0)()), NonceSource::Counter))
    }
}
