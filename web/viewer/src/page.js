// The view of this page, and the controls around it.
export const { viewer } = document.querySelector('t4d-view');
export const { model } = viewer;

export const element = (id) => document.getElementById(id);
