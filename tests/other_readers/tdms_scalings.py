"""Prints what npTDMS makes of scalings: python tdms_scalings.py > ingest/src/formats/tdms/scaling/values.txt"""

import nptdms
import numpy
from nptdms.scaling import get_scaling

RAW = 0xFFFFFFFF


class Raw:
    """What npTDMS knows of a channel's values: raw ones, or those of scalers by id."""

    def __init__(self, data, scaler_data):
        self.data = data
        self.scaler_data = scaler_data


def linear(i, slope, intercept, source):
    return {
        f"NI_Scale[{i}]_Scale_Type": "Linear",
        f"NI_Scale[{i}]_Linear_Slope": slope,
        f"NI_Scale[{i}]_Linear_Y_Intercept": intercept,
        f"NI_Scale[{i}]_Linear_Input_Source": source,
    }


def polynomial(i, coefficients, source):
    p = f"NI_Scale[{i}]_Polynomial_"
    return {
        f"NI_Scale[{i}]_Scale_Type": "Polynomial",
        p + "Coefficients_Size": len(coefficients),
        p + "Input_Source": source,
        **{f"{p}Coefficients[{k}]": c for k, c in enumerate(coefficients)},
    }


def table(i, x, y, source):
    p = f"NI_Scale[{i}]_Table_"
    return {
        f"NI_Scale[{i}]_Scale_Type": "Table",
        p + "Pre_Scaled_Values_Size": len(x),
        p + "Scaled_Values_Size": len(y),
        p + "Input_Source": source,
        **{f"{p}Pre_Scaled_Values[{k}]": c for k, c in enumerate(x)},
        **{f"{p}Scaled_Values[{k}]": c for k, c in enumerate(y)},
    }


def thermistor(i, excitation, value, wires, offset, source):
    p = f"NI_Scale[{i}]_Thermistor_"
    return {
        f"NI_Scale[{i}]_Scale_Type": "Thermistor",
        p + "Excitation_Type": excitation,
        p + "Excitation_Value": value,
        p + "Resistance_Configuration": wires,
        p + "R1_Reference_Resistance": 10000.0,
        p + "Lead_Wire_Resistance": 35.5,
        p + "A": 1.295361e-3,
        p + "B": 2.343159e-4,
        p + "C": 1.018703e-7,
        p + "Temperature_Offset": offset,
        p + "Input_Source": source,
    }


def strain(i, configuration, source):
    p = f"NI_Scale[{i}]_Strain_"
    return {
        f"NI_Scale[{i}]_Scale_Type": "Strain",
        p + "Configuration": configuration,
        p + "Poisson_Ratio": 0.285,
        p + "Gage_Resistance": 350.1,
        p + "Lead_Wire_Resistance": 1.7,
        p + "Initial_Bridge_Voltage": 0.00013,
        p + "Gage_Factor": 2.07,
        p + "Bridge_Shunt_Calibration_Gain_Adjustment": 1.013,
        p + "Voltage_Excitation": 3.3,
        p + "Input_Source": source,
    }


def operands(i, kind, left, right):
    p = f"NI_Scale[{i}]_{kind}_"
    return {
        f"NI_Scale[{i}]_Scale_Type": kind,
        p + "Left_Operand_Input_Source": left,
        p + "Right_Operand_Input_Source": right,
    }


VALUES = [-32768.0, -1.7, 0.0, 0.1, 1.0 / 3.0, 2.0, 1234.5678, 32767.0]
VOLTS = [0.011, 0.25, 0.7, 1.0 / 3.0, 1.9, 2.4]
BRIDGE = [-0.0107, -0.001, 0.0, 0.00013, 0.0031, 0.0251]
POINTS = [-9.0, -2.0, -1.9, -0.3, 0.0, 0.7, 2.9, 3.0, 3.1, 5.0, 6.0, 1e300]

CASES = [
    ("a card: the values of scaler 0", linear(1, 0.0003051850947599719, 0.013, 0), None, {0: VALUES}),
    ("linear", linear(0, 0.1, -0.3, RAW), VALUES, {}),
    ("polynomial, no coefficient", polynomial(0, [], RAW), VALUES, {}),
    ("polynomial, one coefficient", polynomial(0, [0.7], RAW), VALUES, {}),
    ("polynomial, cubic", polynomial(0, [0.7, -0.01, 3.3e-7, 1.1e-11], RAW), VALUES, {}),
    ("polynomial, seventh power", polynomial(0, [0.1, 0.2, -0.3, 0.4, 1e-9, 0.6, 0.7, -0.8], RAW), POINTS, {}),
    ("table", table(0, [-2.0, -0.3, 0.1, 3.0, 5.0], [10.0, 0.1, 0.2, 0.2, -7.7], RAW), POINTS, {}),
    ("table, going down", table(0, [5.0, 3.0, 0.1, -0.3, -2.0], [-7.7, 0.2, 0.2, 0.1, 10.0], RAW), POINTS, {}),
    ("table of one point", table(0, [0.5], [0.25], RAW), POINTS, {}),
    *[
        (f"thermistor, {name} excitation, {wires} wires", thermistor(0, code, value, wires, offset, RAW), VOLTS, {})
        for name, code, value in [("current", 10134, 0.00015), ("voltage", 10322, 2.5)]
        for wires, offset in [(2, 0.0), (3, 273.15), (4, 1.0)]
    ],
    *[
        (f"strain, {name}", strain(0, code, RAW), BRIDGE, {})
        for name, code in [
            ("full bridge I", 10183),
            ("full bridge II", 10184),
            ("full bridge III", 10185),
            ("half bridge I", 10188),
            ("half bridge II", 10189),
            ("quarter bridge I", 10271),
            ("quarter bridge II", 10272),
        ]
    ],
    (
        "a chain of three, not in order",
        {**linear(2, 3.0, 0.3, 0), **linear(0, 0.1, 1.0, 1), **polynomial(1, [0.1, 0.2, 0.3], RAW)},
        VALUES,
        {},
    ),
    ("only the last counts", {**linear(0, 1.0, 1.0, RAW), **linear(1, 2.0, 0.1, RAW)}, VALUES, {}),
    ("add", {**linear(0, 0.1, 0.2, RAW), **linear(1, 3.0, -0.4, RAW), **operands(2, "Add", 0, 1)}, VALUES, {}),
    ("subtract", {**linear(0, 0.1, 0.2, RAW), **operands(1, "Subtract", 0, RAW)}, VALUES, {}),
    ("two scalers", {**operands(3, "Subtract", 0, 2), **linear(4, 0.1, 0.0, 3)}, None, {0: VALUES, 2: VALUES[::-1]}),
    (
        "the same scale twice",
        {**linear(0, 0.3, 0.1, RAW), **operands(1, "Add", 0, 0), **operands(2, "Subtract", 1, 0)},
        VALUES,
        {},
    ),
    (
        "no operation",
        {
            **linear(0, 0.3, 0.1, RAW),
            "NI_Scale[1]_Scale_Type": "AdvancedAPI",
            "NI_Scale[1]_AdvancedAPI_Input_Source": 0,
        },
        VALUES,
        {},
    ),
    ("no operation on the raw values", {"NI_Scale[0]_Scale_Type": "AdvancedAPI"}, VALUES, {}),
    ("strain from a table", {**table(0, [0.0, 1.0], [-0.01, 0.03], RAW), **strain(1, 10271, 0)}, VOLTS, {}),
]

print(f"# As npTDMS {nptdms.__version__} with numpy {numpy.__version__} prints them; made by tests/other_readers/tdms_scalings.py.")
for name, properties, raw, scalers in CASES:
    count = 1 + max(int(key[9:].split("]")[0]) for key in properties)
    properties = {"NI_Number_Of_Scales": count, **properties}
    data = None if raw is None else numpy.array(raw)
    out = get_scaling(properties, {}, {}).scale(Raw(data, {k: numpy.array(v) for k, v in scalers.items()}))
    print(f"\ncase {name}")
    for key, value in properties.items():
        kind = {int: "whole", float: "number", str: "text"}[type(value)]
        print(kind, key, repr(value) if kind != "text" else value)
    show = lambda values: " ".join(repr(float(value)) for value in values)
    if raw is not None:
        print("raw", show(raw))
    for k, v in scalers.items():
        print("scaler", k, show(v))
    print("gives", show(out))
