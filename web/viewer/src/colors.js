// The colours of bodies.
import * as THREE from 'three';

/** Well apart, also for the colour-blind (Okabe and Ito). */
const palette = [0xe69f00, 0x56b4e9, 0x009e73, 0xf0e442, 0x0072b2, 0xd55e00, 0xcc79a7];

/** Steps of this part of a turn never repeat a hue, and keep those taken so far apart. */
const goldenRatio = (Math.sqrt(5) - 1) / 2;

/** Hues begin here: the first twenty colours are then well apart, those of the palette included. */
const firstHue = 0.2;

/** An endless row of colours: the palette, then hues in three shades. */
function colorAt(number) {
  if (number < palette.length) return new THREE.Color(palette[number]);
  const turn = number - palette.length;
  const hue = (firstHue + turn * goldenRatio) % 1;
  return new THREE.Color().setHSL(hue, 0.55, [0.42, 0.72, 0.57][turn % 3], THREE.SRGBColorSpace);
}

/**
 * Colours for bodies: their own, or one that no body of another name has. Bodies of the same name look the same.
 * @param {{name: string, color?: number[]}[]} bodies own colours are linear
 * @param {[string, THREE.Color][]} shown those of bodies that are shown, by name
 * @returns {THREE.Color[]}
 */
export function colorsOf(bodies, shown = []) {
  const ofNames = new Map(shown);
  const own = ({ color }) => new THREE.Color().setRGB(...color.slice(0, 3), THREE.LinearSRGBColorSpace);
  const taken = new Set([...ofNames.values(), ...bodies.filter(({ color }) => color).map(own)].map((color) => color.getHex()));
  let number = 0;
  return bodies.map((body) => {
    if (body.color) return own(body);
    if (!ofNames.has(body.name)) {
      while (taken.has(colorAt(number).getHex())) ++number;
      ofNames.set(body.name, colorAt(number++));
    }
    return ofNames.get(body.name);
  });
}
