/** The file breaks a rule of the specification, or cannot be read here. */
export class Invalid extends Error {
  /**
   * @param {number} at the byte at which the rule is broken
   * @param {string} rule its number in formats/t4d/SPEC.md, such as "C4"
   * @param {string} why
   */
  constructor(at, rule, why) {
    super(`byte ${at}: ${rule}: ${why}`);
    this.name = 'Invalid';
    this.at = at;
    this.rule = rule;
    this.why = why;
  }
}

/** Throws Invalid unless `ok`. */
export function check(ok, at, rule, why) {
  if (!ok) throw new Invalid(at, rule, typeof why === 'function' ? why() : why);
}
