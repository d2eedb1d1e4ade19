// SPDX-License-Identifier: Apache-2.0
// Numbers as people read them.

export const kNone = '–';

/** With so many digits behind the point; a dash for what was not measured. */
export function fixed(x, digits) {
  if (!Number.isFinite(x)) return kNone;
  const text = x.toFixed(digits);
  return Number(text) === 0 ? text.replace('-', '') : text.replace('-', '\u2212');
}

/** With two or three digits that count. */
export function short(x) {
  if (!Number.isFinite(x)) return kNone;
  const size = Math.abs(x);
  if (size >= 99.5 || size === 0) return fixed(x, 0);
  return fixed(x, size >= 9.95 ? 1 : size >= 0.995 ? 2 : 3);
}

/** 1.2e-7 as 1.2·10⁻⁷. */
export function power(x) {
  if (!Number.isFinite(x)) return kNone;
  if (x === 0) return '0';
  const [digits, exponent] = x.toExponential(1).split('e');
  return `${digits}·10${superscript(Number(exponent))}`;
}

export function superscript(n) {
  return [...String(n)].map((c) => (c === '-' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[c])).join('');
}

/** A length, in the unit that suits it. */
export function length(m) {
  if (!Number.isFinite(m)) return kNone;
  return Math.abs(m) < 99.95e-6 ? `${fixed(m * 1e6, 1)} µm` : `${fixed(m * 1e3, 2)} mm`;
}
