// The element <t4d-view>, which `import 't4d-viewer'` defines.

/** A section of a body: a closed triangle mesh that faces outward. */
export interface Section {
  name: string;
  /** Three coordinates each: x, y, z of a slice at a time. */
  points: Float64Array;
  /** Three points each. */
  triangles: Uint32Array;
  numPoints: number;
  numTriangles: number;
  volume: number;
  area: number;
  /** Linear red, green and blue. */
  color: [number, number, number];
}

export interface Measures { triangles: number; vertices: number; volume: number; area: number }

export interface T4dView extends HTMLElement {
  src: string | null;
  compare: string | null;
  /** The address of a report of `t4d track --json`. */
  tracks: string | null;
  time: number;
  hyperplane: string;
  bodies: string[] | null;
  color: string;
  camera: number[] | null;
  view: string;
  controls: boolean;
  autoplay: boolean;
  readonly begin: number;
  readonly end: number;
  readonly paused: boolean;
  load(...files: (string | URL | Blob | ArrayBuffer | Uint8Array)[]): Promise<void>;
  drawn(): Promise<void>;
  play(): void;
  pause(): void;
  fit(): void;
  slice(at?: number | string): Promise<Section[]>;
  measure(at?: number | string): Promise<Measures>;
  toGlb(at?: number | string): Promise<Blob | null>;
  toBlob(type?: string, quality?: number): Promise<Blob>;
}

declare global {
  interface HTMLElementTagNameMap { 't4d-view': T4dView }
  interface HTMLElementEventMap {
    't4d-load': CustomEvent<{ names: string[]; bodies: string[]; begin: number; end: number }>;
    't4d-draw': CustomEvent<Record<string, never>>;
    't4d-time': CustomEvent<{ time: number }>;
    't4d-hyperplane': CustomEvent<{ hyperplane: string }>;
    't4d-camera': CustomEvent<{ camera: number[] }>;
    't4d-error': CustomEvent<{ message: string; error: Error }>;
  }
}
