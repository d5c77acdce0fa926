// Dark or light, which the browser remembers.
import { model } from './page.js';

const themeKey = 't4d-viewer-theme';

export function restoreTheme() {
  try {
    const theme = localStorage.getItem(themeKey);
    if (['dark', 'light'].includes(theme)) document.documentElement.dataset.theme = theme;
  } catch {
    // The browser keeps nothing of this page.
  }
}

const isLight = () => getComputedStyle(document.documentElement).colorScheme === 'light'
  || (!document.documentElement.dataset.theme && matchMedia('(prefers-color-scheme: light)').matches);

export function switchTheme() {
  const theme = isLight() ? 'dark' : 'light';
  document.documentElement.dataset.theme = theme;
  try {
    localStorage.setItem(themeKey, theme);
  } catch {
    // The browser keeps nothing of this page.
  }
  model.changed();
}
