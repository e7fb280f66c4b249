//! Units that message definitions of ROS promise in their comments, where [`crate::units`] knows them.
//!
//! Source: the `.msg` files of <https://github.com/ros2/common_interfaces> and <https://github.com/ros2/rcl_interfaces>. REP 103
//! (<https://www.ros.org/reps/rep-0103.html>) makes them SI throughout. Not here: units the table of units does not hold
//! (m/s, rad/s, degrees Celsius, T, A), and fields that mean one or the other (`JointState.position` is rad or m).

/// Message type without `/msg`, path below it (elements without their index), unit.
const UNITS: &[(&str, &str, &str)] = &[
    ("builtin_interfaces/Time", "", "s"),
    ("builtin_interfaces/Duration", "", "s"),
    // "Absolute pressure reading in Pascals."
    ("sensor_msgs/FluidPressure", "fluid_pressure", "Pa"),
    // "range data [m]", "the size of the arc that the distance reading is valid for [rad]".
    ("sensor_msgs/Range", "range", "m"),
    ("sensor_msgs/Range", "min_range", "m"),
    ("sensor_msgs/Range", "max_range", "m"),
    ("sensor_msgs/Range", "field_of_view", "rad"),
    ("sensor_msgs/LaserScan", "angle_min", "rad"),
    ("sensor_msgs/LaserScan", "angle_max", "rad"),
    ("sensor_msgs/LaserScan", "angle_increment", "rad"),
    ("sensor_msgs/LaserScan", "time_increment", "s"),
    ("sensor_msgs/LaserScan", "scan_time", "s"),
    ("sensor_msgs/LaserScan", "range_min", "m"),
    ("sensor_msgs/LaserScan", "range_max", "m"),
    ("sensor_msgs/LaserScan", "ranges", "m"),
    // "Voltage in Volts (Mandatory)", "Charge percentage on 0 to 1 range".
    ("sensor_msgs/BatteryState", "voltage", "V"),
    ("sensor_msgs/BatteryState", "percentage", "1"),
    // "Expression of the relative humidity from 0.0 to 1.0."
    ("sensor_msgs/RelativeHumidity", "relative_humidity", "1"),
    ("geometry_msgs/Wrench", "force.x", "N"),
    ("geometry_msgs/Wrench", "force.y", "N"),
    ("geometry_msgs/Wrench", "force.z", "N"),
    ("geometry_msgs/Wrench", "torque.x", "N m"),
    ("geometry_msgs/Wrench", "torque.y", "N m"),
    ("geometry_msgs/Wrench", "torque.z", "N m"),
    ("geometry_msgs/Quaternion", "x", "1"),
    ("geometry_msgs/Quaternion", "y", "1"),
    ("geometry_msgs/Quaternion", "z", "1"),
    ("geometry_msgs/Quaternion", "w", "1"),
    ("geometry_msgs/Transform", "translation.x", "m"),
    ("geometry_msgs/Transform", "translation.y", "m"),
    ("geometry_msgs/Transform", "translation.z", "m"),
    ("geometry_msgs/Point", "x", "m"),
    ("geometry_msgs/Point", "y", "m"),
    ("geometry_msgs/Point", "z", "m"),
    ("geometry_msgs/Point32", "x", "m"),
    ("geometry_msgs/Point32", "y", "m"),
    ("geometry_msgs/Point32", "z", "m"),
    ("geometry_msgs/Pose2D", "x", "m"),
    ("geometry_msgs/Pose2D", "y", "m"),
    ("geometry_msgs/Pose2D", "theta", "rad"),
];

/// The unit of a field of a message type.
pub(super) fn unit_of(kind: &str, field: &str) -> Option<&'static str> {
    UNITS.iter().find(|(of, name, _)| *of == kind && *name == field).map(|(_, _, unit)| *unit)
}

#[cfg(test)]
mod tests {
    use super::UNITS;
    use crate::units::Unit;

    #[test]
    fn every_unit_is_known() {
        for (kind, field, unit) in UNITS {
            assert!(Unit::parse(unit).is_some(), "{kind}.{field}: {unit}");
        }
    }
}
