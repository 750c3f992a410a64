//! The microcontroller's program. Built for the host, it prints the arm that it was built for.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod app;
#[cfg(target_os = "none")]
#[allow(unreachable_pub, reason = "the framework makes the types of resources part of public ones")]
mod boards;
#[cfg(target_os = "none")]
mod copy;
#[cfg(target_os = "none")]
mod hard_fault;
#[cfg(target_os = "none")]
mod tick_code;

#[cfg(target_os = "none")]
#[allow(unreachable_pub, reason = "a board's parts are public types")]
mod key;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("scene       {}", arm::NAME);
    println!("robot       {}", arm::ROBOT);
    println!("hash        {:016x}", arm::HASH);
    println!("joints      {}", arm::N);
    println!("rate        {} Hz", arm::RATE_HZ);
    println!("law         {:?}", arm::controller().config().law);
    println!("trig        {:?}", arm::TRIG);
    println!("protocol    {}", link::PROTOCOL_VERSION);
}
