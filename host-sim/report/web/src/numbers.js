// Numbers as the command line shows them: three digits and a prefix.

const PREFIXES = [[1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, '\u00b5'], [1e-9, 'n'], [1e-12, 'p']];

/** `12.3 mrad`; below 1e-12 a number is rounding. */
export function engineering(value, unit) {
  if (!Number.isFinite(value)) return '\u2013';
  const size = Math.abs(value);
  const found = PREFIXES.find(([scale]) => size >= 0.9995 * scale);
  if (!found) return `0 ${unit}`;
  const scaled = value / found[0];
  const digits = Math.abs(scaled) < 9.995 ? 2 : Math.abs(scaled) < 99.95 ? 1 : 0;
  return `${scaled.toFixed(digits)} ${found[1]}${unit}`;
}

/** Power of a thousand and its prefix for an axis whose greatest magnitude is `most`. */
export function prefix(most) {
  return PREFIXES.slice(1).find(([scale]) => most >= 0.1 * scale) ?? [1, ''];
}
