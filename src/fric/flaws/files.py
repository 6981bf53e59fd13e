"""Files: what was guessed, left out or could not be read."""

from fric.flaws.base import Flaw

# fmt: off
LIBRARY_WARNS = Flaw("library-warns", "doubt", "{message}")
SAMPLES_WITHOUT_VALUE = Flaw("samples-without-value", "note", "{samples} samples hold no value, and are left out.")
LINE_CUT = Flaw("line-cut", "note", "The last line is cut, and left out.")
JOINED_IN_PART = Flaw("joined-in-part", "note",
    "Joined over {samples} samples from {begin:.6g} s on, which all channels have{holes:, less {holes} in gaps|}.")
JOINED_THINNED = Flaw("joined-thinned", "note",
    "{channels}: one sample in {every} is taken, at the rate of the slowest channel.")
JOINED_MOVED = Flaw("joined-moved", "note",
    "{channels} (sampled at {rate}) moved by {even:|up to }{by} to the instants of {lead}, between samples.")
CHANNELS_WITHOUT_TIME = Flaw("channels-without-time", "note",
    "The file gives no time, or no numbers, for {channels}: not read.")
SCOPE_SCALE = Flaw("scope-scale", "doubt",
    "Scope shows {channels} scaled or offset; the file does not say whether its values carry that.",
    "Look at 'Scale values before export'.")
RESPONSE_OF_LOOP = Flaw("response-of-loop", "doubt",
    "The response has no voltage as its input: 1 V of it means {volt}.",
    "Take what is designed for it to that input, and no voltage.")
FILES_JOINED = Flaw("files-joined", "note",
    "Joined to one record{more:, and {more} more|}: {share:.0%} of the force goes with the motion{assumed:, little|}.",
    "{assumed:Look whether they are of one run.|}")
CYCLE_ASSUMED = Flaw("cycle-assumed", "doubt",
    "The file names no interval and no axes: assumed are {interval:.3g} ms a row, and axes 1 to 3 in mm.",
    "Export the recording as JSON, which names them, or say otherwise in a mapping.")
THERE_ALREADY = Flaw("there-already", "note", "Already in the file{record:, as record '{record}'|}: skipped.")
RADIUS_ASSUMED = Flaw("radius-assumed", "doubt",
    "No reference: the nominal radius is taken to be {radius}, the roundest within 0.2 % of the measured.",
    "Give `radius=` if it differs: both scales depend on it.")
NO_REFERENCE = Flaw("no-reference", "note",
    "No reference was found: the lag is not known, and glitches are placed by the measured circle.")
COLUMNS_BY_CONTENT = Flaw("columns-by-content", "doubt",
    "No header: {reference:columns {reference} are taken for the reference, |}columns {position} for x and y, in mm "
    "from 0.", "Say otherwise in a mapping, and where the voltage is.")
COLUMNS_LEFT_OUT = Flaw("columns-left-out", "doubt", "Columns are left out: {columns}.")
AXES_LEFT_OUT = Flaw("axes-left-out", "note", "The file has other axes, which were not read: {axes}.",
    "Ingest each axis into a separate log file (`axis=`). `fric auto` reads all of them.")
CELLS_DROPPED = Flaw("cells-dropped", "doubt",
    "{dropped} of {samples} samples are dropped: a cell is not a number, or a time comes twice.")
SAMPLES_MISSING = Flaw("samples-missing", "doubt", "Samples are missing at regular intervals: {rates}.")
UNIT_FAILED = Flaw("unit-failed", "doubt", "{why}")
NO_LOG = Flaw("no-log", "doubt", "There is no log.")
FILE_COPIES = Flaw("file-copies", "note", "Left out as copies of other files: {files}.")
FOLDERS_TOGETHER = Flaw("folders-together", "note", "Taken as one axis {axis}: files of the same names in {folders}.",
    "If they are of two machines or days, run each folder by itself, or each as an axis (`axis=`).")
FILE_LEFT_OUT = Flaw("file-left-out", "doubt", "Left out: {why}.",
    "{propose:`{propose}` writes a mapping to look at and fill in, for `mapping=`.|}")
FORCE_BY_FILE = Flaw("force-by-file", "doubt",
    "The force of {files} counts the other way: friction would drive the axis. It is turned.",
    "Look why: a motor that was turned, or another recorder.")
RECORD_LEFT_OUT = Flaw("record-left-out", "doubt", "Left out, since it cannot be used: {why}.")
FILE_UNUSED = Flaw("file-unused", "note",
    "Read, and not used: {unfit:{why}|axis {axis} needs no {kinds}}{others:; others of its kind are used|}.",
    "{motion:It is neither strokes nor a sine: does it stick? `fric validate` compares results with it.|}"
    "{other:`fric inspect` says what it lacks.|}"
    "{alone:See what is missing for its axis.|}")
MAPPING_BUNDLED = Flaw("mapping-bundled", "note",
    "Read with the bundled mapping '{mapping}', the only one that fits: {files}.")
MAPPING_PROPOSED = Flaw("mapping-proposed", "note", "Columns were recognised by their values ({means}): {files}.")
MAPPING_BESIDE = Flaw("mapping-beside", "note", "Read with the mapping beside it, {mapping}, of earlier answers.",
    "Change it there, or remove it to be asked again.")
MAPPING_ASSUMED = Flaw("mapping-assumed", "doubt", "Assumed of {files}: {what}.",
    "Check {mapping:{mapping}|the mapping}, correct it, and give it with `mapping=`.")
MAPPING_OPEN = Flaw("mapping-open", "doubt", "Left out, since their meaning is not clear: {files}: {what}.",
    "Say `assume=True` to take the likeliest, or give a mapping (`fric ingest FILES --propose MAP.yaml`): `mapping=`.")
MAPPING_AMBIGUOUS = Flaw("mapping-ambiguous", "doubt", "It is left out: {mappings} all fit.",
    "Give one of them with `mapping=`.")
STEP_FAILED = Flaw("step-failed", "doubt", "{why}")
GAINS_DESIGNED = Flaw("gains-designed", "doubt",
    "fric designed the controller's gains: with others the glitch differs.",
    "Give yours: `controllers='K_v=… 1/s, K_p=… V*s/m, K_i=… V/m'`; or log reference and voltage.")
CIRCLE_FAILED = Flaw("circle-failed", "doubt", "{why}")
