//! Drives of the joints, as Rust source.

use super::expression::{Item, call, integer, list, number, record, word};
use dynamics_core::drive::{DataRate, Drives, Gearing, MitDrive, MitRanges, PwmDrive, Range};

/// Rust source of a module with one function, `drives() -> Drives<N>`, for use together with [`super::arm_module`].
#[must_use]
pub fn drives_module<const N: usize>(drives: &Drives<N>) -> String {
    let (types, item) = match drives {
        Drives::Link => ("Drives", word("Drives::Link")),
        Drives::Mit(all) => {
            let all = list(all.iter().map(mit_item).collect());
            ("Drives, Gearing, MitDrive, MitRanges, Range", call("Drives::Mit", vec![all]))
        }
        Drives::Pwm(all) => {
            let all = list(all.iter().map(pwm_item).collect());
            ("Drives, Gearing, PwmDrive", call("Drives::Pwm", vec![all]))
        }
    };
    let types = if types.contains(',') { format!("{{{types}}}") } else { types.to_owned() };
    format!(
        "//! Generated from a robot and a scene file. Do not edit: change the files instead.\n\n\
         use dynamics_core::drive::{types};\n\n\
         /// Drives of the joints.\npub const fn drives() -> Drives<{N}> {{\n    {}\n}}\n",
        item.print(4)
    )
}

fn whole(x: impl Into<i64>) -> Item {
    integer(x.into())
}

fn gearing_item(gearing: &Gearing) -> Item {
    let Gearing { ratio, per_ratio, zero } = gearing;
    record("Gearing", vec![("ratio", number(*ratio)), ("per_ratio", number(*per_ratio)), ("zero", number(*zero))])
}

fn range_item(range: &Range) -> Item {
    let Range { min, max } = range;
    record("Range", vec![("min", number(*min)), ("max", number(*max))])
}

fn mit_item(drive: &MitDrive) -> Item {
    let MitDrive {
        bus,
        data_rate,
        id,
        reply_id,
        reply_bytes,
        temperature_offset,
        ranges,
        gearing,
        damping,
        timeout,
        restart_ticks,
        absolute,
    } = drive;
    let MitRanges { position, velocity, kp, kd, torque } = ranges;
    let ranges = [("position", position), ("velocity", velocity), ("kp", kp), ("kd", kd), ("torque", torque)];
    record(
        "MitDrive",
        vec![
            ("bus", whole(*bus)),
            ("data_rate", data_rate.map_or_else(|| word("None"), |rate| call("Some", vec![data_rate_item(rate)]))),
            ("id", whole(*id)),
            ("reply_id", whole(*reply_id)),
            ("reply_bytes", whole(*reply_bytes)),
            ("temperature_offset", temperature_offset.map_or_else(|| word("None"), |x| call("Some", vec![number(x)]))),
            ("ranges", record("MitRanges", ranges.map(|(name, range)| (name, range_item(range))).into())),
            ("gearing", gearing_item(gearing)),
            ("damping", number(*damping)),
            ("timeout", whole(*timeout)),
            ("restart_ticks", whole(*restart_ticks)),
            ("absolute", word(if *absolute { "true" } else { "false" })),
        ],
    )
}

fn data_rate_item(rate: DataRate) -> Item {
    // By its path: drives with classic frames do not name the type.
    word(match rate {
        DataRate::Mbit2 => "dynamics_core::drive::DataRate::Mbit2",
        DataRate::Mbit5 => "dynamics_core::drive::DataRate::Mbit5",
    })
}

fn pwm_item(drive: &PwmDrive) -> Item {
    let PwmDrive {
        channel,
        gearing,
        encoder_zero,
        encoder_reversed,
        jump_max,
        speed_per_count,
        torque_constant,
        per_torque_constant,
        resistance,
        per_resistance,
        supply,
        per_supply,
        current_max,
    } = drive;
    record(
        "PwmDrive",
        vec![
            ("channel", whole(*channel)),
            ("gearing", gearing_item(gearing)),
            ("encoder_zero", whole(*encoder_zero)),
            ("encoder_reversed", word(if *encoder_reversed { "true" } else { "false" })),
            ("jump_max", whole(*jump_max)),
            ("speed_per_count", number(*speed_per_count)),
            ("torque_constant", number(*torque_constant)),
            ("per_torque_constant", number(*per_torque_constant)),
            ("resistance", number(*resistance)),
            ("per_resistance", number(*per_resistance)),
            ("supply", number(*supply)),
            ("per_supply", number(*per_supply)),
            ("current_max", number(*current_max)),
        ],
    )
}
