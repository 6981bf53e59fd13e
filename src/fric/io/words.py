"""What headers call channels, in the languages of those who write them: the one list that all readers of columns ask.

An order of words is their rank where several columns of a circle test have one role: the first is taken.
"""

TIME = ("time", "zeit", "timestamp", "clock", "tempo", "temps", "tiempo")
ERROR = ("error", "deviation", "diff", "difference", "fehler", "schleppabstand", "abweichung", "errore", "scostamento",
         "erreur", "écart")  # fmt: skip
REFERENCE = ("reference", "ref", "cmd", "command", "commanded", "demand", "set", "setpoint", "target", "soll",
             "set point", "sollwert", "desired", "riferimento", "consigne", "référence", "consigna",
             "referencia")  # fmt: skip
POSITION = ("position", "pos", "weg", "lage", "winkel", "angle", "displacement", "travel", "encoder", "posizione",
            "spostamento", "déplacement", "posición", "posicion")  # fmt: skip
VELOCITY = ("velocity", "speed", "vel", "velo", "spd", "geschwindigkeit", "drehzahl", "velocità", "vitesse",
            "velocidad")  # fmt: skip
FORCE = ("force", "torque", "trq", "frc", "friction", "kraft", "moment", "drehmoment", "reibung", "forza", "coppia",
         "attrito", "fuerza")  # fmt: skip
CURRENT = ("current", "curr", "iq", "i q", "amp", "amps", "ampere", "strom", "corrente", "courant", "corriente",
           "intensidad")  # fmt: skip
LOAD = ("load", "last", "auslastung", "carico", "charge", "carga")
ACCELERATION = ("acceleration", "accel", "acc", "beschleunigung", "accelerazione", "accélération", "aceleración",
                "aceleracion", "jerk", "ruck")  # fmt: skip
BESIDE_MOTION = ("temperature", "temp", "temperatur", "temperatura", "température", "bus", "dc", "supply",
                 "zwischenkreis", "power", "leistung", "pressure", "druck", "status", "state", "zustand", "mode",
                 "modus", "flag", "id", "i d", "stato", "estado", "état", "vibration", "batt", "battery")  # fmt: skip
"""What drives log beside a motion."""
MEASURED = ("actual", "act", "ist", "istwert", "measured", "meas", "feedback", "fb", "fbk", "encoder", "enc", "real",
            "effettiva", "réelle", "reelle", "mesurée", "medida", "misurata", "true")  # fmt: skip
INPUT = ("input", "voltage", "volt", "spannung", "control signal", "tensione")

ASKED = (*REFERENCE, "nominal")
"""What the reference of an axis of a circle is called; a nominal torque of a log is none."""
SENSED = ("encoder", "enc", "actual", "act", "measured", "meas", "feedback", "fb", "position", "pos", "ist", "")
"""What the position of an axis of a circle is called beside its axis, the surest first; an axis alone comes last."""
DRIVEN = ("input", "voltage", "u", "control", "output", "command", "signal", "drive", "motor", "spannung", "")
"""What the voltage of an axis of a circle is called."""
PUSHED = ("force", "motor", "thrust", "drive", "kraft", "")
"""What the force of an axis of a circle is called."""
BESIDE = frozenset({"position", "pos", "axis", "value", "lage", "achse", "wert"})
"""Words that say nothing of a position's role beside one that does: an actual position is actual."""
ANGLES = ("angle", "theta", "position angle", "winkel")
DEVIATIONS = ("deviation", "radial deviation", "radial error", "radius deviation", "error", "abweichung")

CHANNELS = {"error": ERROR, "time": TIME, "reference": REFERENCE, "position": POSITION, "velocity": VELOCITY,
            "force": FORCE, "input": INPUT}  # fmt: skip
"""Words of a name that tell a channel, in the order in which they are asked: a reference position is a reference.

Where a word means another thing in English (tension, couple), the unit tells; an error is no channel."""
LETTERS = {"t": "time", "z": "position", "x": "position", "q": "position", "v": "velocity", "f": "force", "u": "input"}
"""Names of one letter."""
EXACT = {"torque": "force", "voltage": "input", "t": "time"}
"""Whole names that are taken for a channel without a question, beside its own name."""
OF_MEANS = {
    "mean velocity": "velocity",
    "speed": "velocity",
    "mean force": "force",
    "mean torque": "force",
    "std": "deviation",
    "sd": "deviation",
    "standard deviation": "deviation",
    "standard error": "error",
    "sem": "error",
    "count": "n",
    "samples": "n",
}
"""What a table of forces and velocities calls its columns besides."""
