//! Faults of what is logged: stamps, rows, readings.

use super::{Fault, Target, is_live};
use crate::rehearse::bench::DeviceLog;
use crate::rehearse::plan::Plan;
use crate::rehearse::random::Normal;

/// Clock faults: s, and s per s.
const CLOCK_OFFSET_S: f64 = 0.25;
const CLOCK_DRIFT: f64 = 2000e-6;

/// Hits what a device logged. Gives the first and last sample that are hit, from 1; `None` for faults of another stage.
///
/// # Errors
/// Why there is nothing to hit.
pub fn spoil_log(
    fault: Fault,
    target: &Target,
    plan: &Plan,
    log: &mut DeviceLog,
    noise: &mut Normal,
) -> Result<Option<(usize, usize)>, String> {
    let rows = log.stamps_s.len();
    let part = |tenths: usize| rows * tenths / 10;
    let middle = part(5);
    if rows < 100 {
        return Err(format!("{rows} samples in the run: a fault needs at least 100"));
    }
    let rate_hz = plan.devices[log.device].rate_hz;
    // With the decimals that the log has, so that nothing but the fault is new.
    let rounded = |value: f64, decimals: usize| {
        let scale = 10_f64.powi(i32::try_from(decimals).unwrap_or(6));
        (value * scale).round() / scale + 0.0
    };
    let stamp_decimals = plan.devices[log.device].decimals;
    let column = log.columns.iter().position(|column| Some(column.channel) == target.channel);
    if column.is_none() && !fault.is_of_device() {
        return Ok(None);
    }
    let column = column.unwrap_or(0);
    match fault {
        Fault::Gap => {
            let gone = part(4)..part(5);
            log.true_s.drain(gone.clone());
            log.stamps_s.drain(gone.clone());
            log.columns.iter_mut().for_each(|column| drop(column.values.drain(gone.clone())));
            return Ok(Some((gone.start, gone.start + 1)));
        }
        Fault::Jitter => {
            for stamp in &mut log.stamps_s {
                *stamp += (noise.next() * 0.3).clamp(-0.45, 0.45) / rate_hz;
                *stamp = rounded(*stamp, stamp_decimals);
            }
            return Ok(Some((1, rows)));
        }
        Fault::TimeBack => {
            let back_s = 50.0 / rate_hz;
            log.stamps_s[middle..].iter_mut().for_each(|stamp| *stamp = rounded(*stamp - back_s, stamp_decimals));
            return Ok(Some((middle + 1, middle + 50)));
        }
        Fault::ClockOffset | Fault::ClockDrift => {
            let (offset_s, drift) =
                if fault == Fault::ClockOffset { (CLOCK_OFFSET_S, 0.0) } else { (0.0, CLOCK_DRIFT) };
            for stamp in &mut log.stamps_s {
                *stamp = rounded(offset_s + *stamp * (1.0 + drift), stamp_decimals);
            }
            return Ok(Some((1, rows)));
        }
        Fault::DuplicateStamps => {
            let stamp = log.stamps_s[middle];
            log.stamps_s[middle + 1..=middle + 10].fill(stamp);
            return Ok(Some((middle + 2, middle + 11)));
        }
        _ => {}
    }
    let said = log.columns[column].unit;
    if fault == Fault::SwappedChannels {
        let is_other = |other: &usize| *other != column && is_live(&plan.channels[log.columns[*other].channel]);
        let other = (0..log.columns.len()).find(is_other).ok_or("the device logs one channel only")?;
        let values = std::mem::take(&mut log.columns[column].values);
        log.columns[column].values = std::mem::replace(&mut log.columns[other].values, values);
        return Ok(Some((1, rows)));
    }
    let decimals = plan.channels[log.columns[column].channel].decimals;
    let values = &mut log.columns[column].values;
    let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
    let range = match fault {
        Fault::DroppedInstrument => {
            values[part(6)..].fill(f64::NAN);
            (part(6) + 1, rows)
        }
        Fault::UnitPsi | Fault::UnitBar | Fault::UnitPa | Fault::UnitCm | Fault::Hundredfold | Fault::WrongSign => {
            let factor = fault.factor(said);
            for value in values.iter_mut() {
                // Another unit has other decimals.
                *value = rounded(*value * factor, decimals.max(4));
            }
            (1, rows)
        }
        Fault::Saturation => {
            let end = least + 0.85 * (most - least);
            let end = rounded(end, decimals);
            let first = values.iter().position(|value| *value > end).unwrap_or(0);
            let last = values.iter().rposition(|value| *value > end).unwrap_or(0);
            for value in values.iter_mut() {
                *value = value.min(end);
            }
            (first + 1, last + 1)
        }
        Fault::Flatline => {
            let value = values[part(4)];
            values[part(4)..part(7)].fill(value);
            (part(4) + 1, part(7))
        }
        Fault::NotANumber => {
            values[middle..middle + 10].fill(f64::NAN);
            (middle + 1, middle + 10)
        }
        Fault::SlippedZero => {
            let slip = 0.1 * (most - least);
            values[middle..].iter_mut().for_each(|value| *value = rounded(*value + slip, decimals));
            (middle + 1, rows)
        }
        // Of the bench, or of the bytes; where they lie is said there.
        _ => (middle + 1, middle + 1),
    };
    Ok(Some(range))
}
