//! Names, bit timing, host frames, endpoints: tables of good and bad input.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::super::adapter_name::AdapterName;
use super::super::frame::CanFrame;
use super::bit_timing::{BitTiming, Limits};
use super::host_frame::{Content, decode, encode};
use super::plugged::{EndpointFacts, Endpoints, choose, endpoints, udev_rule};
use dynamics_core::drive::bus_time::Identifier;
use embedded_can::{ExtendedId, Frame as _, Id};
use proptest::prelude::{any, prop_assert_eq, proptest};

#[test]
fn names_have_a_serial_number_and_a_channel() {
    let name = |serial: &str, channel| AdapterName::GsUsb(Some(serial.to_owned()), channel);
    for (text, expected, shown) in [
        ("gs_usb", AdapterName::GsUsb(None, 0), "gs_usb"),
        ("gs_usb:004100265542", name("004100265542", 0), "gs_usb:004100265542"),
        ("gs_usb:0041:0", name("0041", 0), "gs_usb:0041"),
        ("gs_usb:0041:1", name("0041", 1), "gs_usb:0041:1"),
    ] {
        let parsed: AdapterName = text.parse().unwrap();
        assert_eq!((parsed.to_string().as_str(), &parsed), (shown, &expected), "{text}");
    }
    for (bad, part) in [
        ("gs_usb:", "is no serial number"),
        ("gs_usb::1", "is no serial number"),
        ("gs_usb:/dev/ttyACM0", "is no serial number"),
        ("gs_usb:a b", "is no serial number"),
        ("gs_usb:0041:", "expected a channel from 0 to 255"),
        ("gs_usb:0041:x", "expected a channel"),
        ("gs_usb:0041:256", "expected a channel"),
        ("gs_usb:0041:-1", "expected a channel"),
        ("gs_usb:0041:1:2", "expected a channel"),
        ("gsusb:0041", "is no kind of adapter"),
    ] {
        let error = bad.parse::<AdapterName>().unwrap_err();
        assert!(error.contains(part), "{bad}: {error}");
    }
    assert!(name("ab", 0).is_same_adapter(&name("AB", 1)) && !name("ab", 0).is_same_adapter(&name("ac", 0)));
    assert!(name("ab", 0).is_same_adapter(&AdapterName::GsUsb(None, 0)), "the only one");
    assert!(!name("ab", 0).is_same_adapter(&AdapterName::Socket("can0".into())));
    let line = AdapterName::GsUsb(None, 0).line(Identifier::Standard).unwrap();
    // 264 bits and a sixth of stuff bits at 12 Mbit/s; a command has an echo.
    assert_eq!((line.reply_ns(), line.commands_ns(6)), (25_666, 12 * 25_666));
}

#[test]
fn bit_timings_are_those_of_the_table() {
    let classic = ((1, 16), (1, 8), 4, (1, 1024, 1));
    let fd = ((1, 256), (1, 128), 128, (1, 512, 1));
    // Clock, limits, and brp, tseg1, tseg2, sjw.
    let cases = [
        (48, classic, Some([3, 13, 2, 2])),
        (42, classic, Some([3, 11, 2, 2])),
        (36, classic, Some([2, 15, 2, 2])),
        (8, classic, Some([1, 6, 1, 1])),
        (40, fd, Some([1, 34, 5, 5])),
        (80, fd, Some([1, 69, 10, 10])),
        (170, fd, Some([1, 148, 21, 21])),
        // Only even dividers.
        (48, ((1, 16), (1, 8), 4, (2, 1024, 2)), Some([4, 9, 2, 2])),
        // Too slow, too few quanta, a sample point that is too early, and limits without a value within.
        (7, classic, None),
        (48, ((1, 5), (1, 1), 1, (1, 1024, 1)), None),
        (48, ((1, 4), (8, 8), 4, (1, 1024, 1)), None),
        (48, ((16, 1), (8, 1), 4, (1, 1024, 1)), None),
        (48, ((1, 16), (1, 8), 4, (5, 4, 0)), None),
        (0, classic, None),
    ];
    for (clock, (tseg1, tseg2, sjw_max, brp), expected) in cases {
        let limits = Limits { features: 0, clock_hz: clock * 1_000_000, tseg1, tseg2, sjw_max, brp };
        let found = limits.timing();
        let shown = found.map(|it: BitTiming| [it.brp, it.prop_seg + it.phase_seg1, it.phase_seg2, it.sjw]);
        assert_eq!(shown, expected, "{limits:?}");
    }
}

#[test]
fn frames_are_those_of_the_protocol() {
    let encoded = |frame: &CanFrame| {
        let mut bytes = Vec::new();
        encode(frame, 9, 1, &mut bytes);
        bytes
    };
    let frame = CanFrame::of(0x123, false, &[0xAA, 0xBB]).unwrap();
    assert_eq!(encoded(&frame), [9, 0, 0, 0, 0x23, 1, 0, 0, 2, 1, 0, 0, 0xAA, 0xBB, 0, 0, 0, 0, 0, 0]);
    let remote = CanFrame::new_remote(Id::Extended(ExtendedId::new(0x1234_5678).unwrap()), 3).unwrap();
    assert_eq!(encoded(&remote)[4..9], [0x78, 0x56, 0x34, 0xD2, 3]);
    let mut received = encoded(&remote);
    received[..4].fill(0xFF);
    assert_eq!(decode(&received, 1), (Content::Frame(remote), false));
    assert_eq!(decode(&received, 0), (Content::Nothing, false), "another channel");
    // Nine bytes, an identifier of 12 bits, a CAN FD frame.
    let head = |raw: u32, length, flags| [&[0xFF; 4][..], &raw.to_le_bytes(), &[length, 0, flags, 0], &[0; 8]].concat();
    for bad in [head(1, 9, 0), head(0x800, 8, 0), head(1, 8, 2), vec![0; 19], vec![0; 1]] {
        assert_eq!(decode(&bad, 0).0, Content::Unreadable, "{bad:?}");
    }
}

proptest! {
    #[test]
    fn every_frame_comes_back(raw in 0u32..0x2000_0000, extended in any::<bool>(), data in proptest::collection::vec(any::<u8>(), 0..=8), stamp in any::<[u8; 4]>()) {
        let raw = if extended { raw } else { raw & 0x7FF };
        let frame = CanFrame::of(raw, extended, &data).unwrap();
        let mut bytes = Vec::new();
        encode(&frame, u32::MAX, 2, &mut bytes);
        prop_assert_eq!(decode(&bytes, 2), (Content::Frame(frame), false));
        bytes.extend(stamp);
        prop_assert_eq!(decode(&bytes, 2), (Content::Frame(frame), false));
    }

    #[test]
    fn no_bytes_are_too_bad(bytes in proptest::collection::vec(any::<u8>(), 0..100), words in any::<[u32; 10]>()) {
        let _ = decode(&bytes, 0);
        let limits = Limits::of(&words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>()).unwrap();
        if let Some(timing) = limits.timing() {
            let quanta = u64::from(1 + timing.prop_seg + timing.phase_seg1 + timing.phase_seg2);
            prop_assert_eq!(quanta * u64::from(timing.brp) * 1_000_000, u64::from(limits.clock_hz));
        }
    }
}

#[test]
fn endpoints_are_taken_from_the_descriptor() {
    let of = |address, is_bulk, packet| EndpointFacts { address, is_bulk, packet };
    for (all, input, input_bytes, output) in [
        (vec![of(0x81, true, 32), of(0x02, true, 32)], 0x81, 64, 0x02),
        (vec![of(0x01, true, 64), of(0x81, true, 64)], 0x81, 64, 0x01),
        (vec![of(0x83, false, 8), of(0x82, true, 512), of(0x05, true, 512), of(0x06, true, 512)], 0x82, 512, 0x05),
        (vec![of(0x81, true, 24), of(0x02, true, 24)], 0x81, 72, 0x02),
    ] {
        assert_eq!(endpoints(&all).unwrap(), Endpoints { input, input_bytes, output }, "{all:?}");
    }
    for bad in [
        vec![],
        vec![of(0x81, true, 64)],
        vec![of(0x02, true, 64)],
        vec![of(0x81, false, 64), of(0x02, true, 64)],
        vec![of(0x81, true, 0), of(0x02, true, 64)],
    ] {
        assert!(endpoints(&bad).unwrap_err().to_string().contains("expected one in each direction"), "{bad:?}");
    }
}

#[test]
fn an_adapter_is_chosen_by_its_serial_number() {
    let two = [Some("0041AB"), Some("0042"), None];
    assert_eq!(choose(&two, Some("0041ab")).unwrap(), 0);
    assert_eq!(choose(&two, Some("0042")).unwrap(), 1);
    assert_eq!(choose(&[None], None).unwrap(), 0);
    type Case<'a> = (&'a [Option<&'a str>], Option<&'a str>, &'a str);
    let cases: [Case<'_>; 5] = [
        (&[], None, "no adapter with the protocol gs_usb is plugged in"),
        (&[], Some("1"), "no adapter with the protocol gs_usb is plugged in"),
        (
            &two,
            None,
            "3 such adapters are plugged in, expected the name of one: gs_usb:0041AB, gs_usb:0042, one without a serial number",
        ),
        (&two, Some("0043"), "no adapter with this serial number is plugged in, but gs_usb:0041AB"),
        (&[Some("1"), Some("1")], Some("1"), "several adapters with this serial number"),
    ];
    for (serials, wanted, part) in cases {
        let error = choose(serials, wanted).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    let rule = udev_rule(0x1D50, 0x606F);
    assert!(rule.contains(r#"ATTR{idVendor}=="1d50", ATTR{idProduct}=="606f", MODE="0660""#), "{rule}");
}

#[cfg(target_os = "linux")]
#[test]
fn an_adapter_of_the_kernel_s_driver_is_refused_with_the_name_of_its_interface() {
    let device = std::env::temp_dir().join(format!("newtau-gs_usb-driver-{}", std::process::id()));
    std::fs::create_dir_all(device.join("1-2:1.1")).unwrap();
    super::kernel_driver::check(&device).unwrap();
    super::kernel_driver::check(&device.join("missing")).unwrap();
    for name in ["can1", "can0"] {
        std::fs::create_dir_all(device.join("1-2:1.0/net").join(name)).unwrap();
    }
    let error = super::kernel_driver::check(&device).unwrap_err();
    std::fs::remove_dir_all(&device).unwrap();
    assert!(error.to_string().contains("use `--can can0` or `--can can1` instead"), "{error}");
}
