"""How C is written: the precision of numbers, prefixes, and the functions that the C library is not asked for."""

from dataclasses import dataclass

_POWERS = (64, 32, 16, 8, 4, 2, 1)
HELPERS = {
    "min": """static inline {real} {prefix}min({real} a, {real} b)
{{
    return (a < b) ? a : b;
}}""",
    "max": """static inline {real} {prefix}max({real} a, {real} b)
{{
    return (a > b) ? a : b;
}}""",
    "copysign": """/* The size of a with the sign of b. */
static inline {real} {prefix}copysign({real} a, {real} b)
{{
    return (b < {zero}) ? (-{fabs}(a)) : {fabs}(a);
}}""",
    "log1p": """/* ln(1 + x) for x > -1: powers of two are taken out of 1 + x, the series of artanh gives the rest. */
static inline {real} {prefix}log1p({real} x)
{{
    static const {real} factors[7] = {{{factors}}};
    static const {real} powers[7] = {{{powers}}};
    {real} y = {one} + x;
    {real} twos = {zero};
    {real} sum = {zero};
    for (int32_t i = 0; i < 7; ++i) {{
        if (y >= factors[i]) {{
            y = y / factors[i];
            twos = twos + powers[i];
        }}
        if ((y * factors[i]) <= {one}) {{
            y = y * factors[i];
            twos = twos - powers[i];
        }}
    }}
    {real} rest = ({fabs}(twos) > {zero}) ? (y - {one}) : x;
    {real} s = rest / ({two} + rest);
    {real} order = {last};
    for (int32_t n = 0; n < 21; ++n) {{
        sum = ((sum * s) * s) + ({one} / order);
        order = order - {two};
    }}
    return (twos * {ln_2}) + (({two} * s) * sum);
}}""",
}


@dataclass(frozen=True)
class Dialect:
    """How numbers are written: in double or in single precision, with a prefix for every name."""

    prefix: str  # What every name of the file begins with
    single: bool = False  # True for ``float``
    avoid: frozenset[str] = frozenset()  # Names that mean something else where the C will stand

    @property
    def real(self) -> str:
        """The type of real numbers."""
        return "float" if self.single else "double"

    def number(self, value: float) -> str:
        """Return a real constant, exact in the precision of the dialect."""
        if not self.single:
            return repr(float(value))
        import numpy as np

        text = str(np.float32(value))
        return f"{text if any(c in text for c in '.e') else text + '.0'}F"

    def function(self, name: str) -> str:
        """Return a function of the C library as it is called in this precision."""
        return f"{name}f" if self.single else name


def helper(name: str, dialect: Dialect) -> str:
    """Return the definition of an intrinsic function that C's library is not asked for."""
    number, fabs = dialect.number, dialect.function("fabs")
    return HELPERS[name].format(
        real=dialect.real, prefix=dialect.prefix, fabs=fabs, zero=number(0.0), one=number(1.0), two=number(2.0),
        ln_2=number(0.6931471805599453), factors=", ".join(number(2.0**n) for n in _POWERS),
        powers=", ".join(number(n) for n in _POWERS), last=number(41.0),
    )  # fmt: skip
