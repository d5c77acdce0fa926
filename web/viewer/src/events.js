// The list of events of tracks, over the picture.
import { shown } from './common.js';

/** What an event is called in the list: its time, its name, and the tracks before and after. */
function textOf({ time, event, body, before, after }, bodies) {
  const tracks = before.join() === after.join() ? before.join(' ') : `${before.join(' ')} → ${after.join(' ')}`;
  return `${shown(time)}  ${event}  ${bodies > 1 ? `${body} ` : ''}${tracks.trim()}`;
}

export class EventList {
  /** @param {import('./viewer.js').Viewer} viewer */
  constructor(viewer) {
    this.viewer = viewer;
    this.times = [];
    viewer.addEventListener('files', () => this.fill());
    viewer.addEventListener('change', () => this.mark());
  }

  fill() {
    const { viewer, viewer: { model, find } } = this;
    const events = model.panes.length > 0 ? model.tracks?.events ?? [] : [];
    const bodies = model.tracks?.ofBodies.size ?? 0;
    this.times = events.map(({ time }) => time);
    find('events').hidden = !model.tracks || model.panes.length === 0;
    find('eventCount').textContent = `${events.length} event${events.length === 1 ? '' : 's'}`;
    find('eventList').replaceChildren(...events.map((event) => {
      const item = document.createElement('li');
      const button = Object.assign(document.createElement('button'), { textContent: textOf(event, bodies) });
      button.onclick = () => viewer.showEvent(event);
      item.append(button);
      return item;
    }));
    this.mark();
  }

  /** Marks those of the time that is shown. */
  mark() {
    const { model: { state }, find } = this.viewer;
    [...find('eventList').children].forEach(({ firstChild }, i) => {
      if (state.cut === 't' && this.times[i] === state.t) firstChild.setAttribute('aria-current', 'time');
      else firstChild.removeAttribute('aria-current');
    });
  }
}
