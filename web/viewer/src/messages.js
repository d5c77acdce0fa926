// The box for what went wrong.
import { element } from './common.js';
import { sliderKey, state } from './page.js';

let messageOf = ''; // what was shown when the message came

/** What is shown, but for the camera and the looks that no message is about. */
const shownKey = () => JSON.stringify([state.cut, state[sliderKey()], state.normal, state.hidden, state.color, state.drop]);

export function say(...lines) {
  const box = element('message');
  box.replaceChildren(...lines.map((line) => Object.assign(document.createElement('p'), { textContent: line })));
  const close = Object.assign(document.createElement('button'), { textContent: 'Close' });
  close.onclick = () => { box.hidden = true; };
  box.append(close);
  box.hidden = false;
  messageOf = shownKey();
}

export function showError(error, detail = '') {
  say(...[error.message, detail].filter(Boolean));
  if (error.isKnown === false || error.workerStack) console.error(error.workerStack ?? error);
}

/** Whether there was a message about what is shown, also if it was closed. */
export const wasSaid = () => messageOf === shownKey();

export function hideOldMessage() {
  if (!wasSaid()) element('message').hidden = true;
}
