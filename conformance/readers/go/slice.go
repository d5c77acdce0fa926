package main

import "math"

// A hyperplane has the points p with n.p = offset.
type hyperplane struct {
	n      point
	offset float64
	atTime bool // n is (0, 0, 0, 1)
}

type sliceAnswer struct {
	Bodies []bodySlice `json:"bodies"`
	Axes   [3][]double `json:"axes"`
}

type bodySlice struct {
	Name      string   `json:"name"`
	Points    int      `json:"points,string"`
	Triangles int      `json:"triangles,string"`
	Volume    double   `json:"volume"`
	Area      double   `json:"area"`
	Min       []double `json:"min"`
	Max       []double `json:"max"`
}

// slice reads what a slice needs.
func slice(f *file, h hyperplane) (answer sliceAnswer) {
	var c *catalog
	if f.indexed {
		c = readIndex(f)
	} else {
		c = scan(f, func(*slab) {})
	}
	axes := h.axes()
	for i, axis := range axes {
		answer.Axes[i] = doubles(axis[:])
	}
	flipped := det4(axes[0], axes[1], axes[2], h.n) < 0
	slabs := make([][]entry, len(c.bodies))
	for _, s := range c.slabs {
		slabs[s.body] = append(slabs[s.body], s)
	}
	for i, all := range slabs {
		cut := newCut(h, axes, flipped)
		last := all[len(all)-1].end
		cut.closed = h.atTime && h.offset == last
		for number, s := range all {
			if h.atTime && !(s.end > h.offset || cut.closed && s.end == last) {
				continue // a later slab answers
			}
			if h.meets(s) {
				found := c.readSlab(c.at[s.offset])
				c.requireSame(s, found.entry, s.offset)
				cut.add(found, uint64(number))
			}
			if h.atTime {
				break
			}
		}
		answer.Bodies = append(answer.Bodies, cut.answer(c.head.bodies[i]))
	}
	return answer
}

// meets tells whether the hyperplane can have points of a slab: n.p lies between its values at two corners
// of the box, after rounding, too.
func (h hyperplane) meets(s entry) bool {
	if h.atTime {
		return s.begin <= h.offset && h.offset <= s.end
	}
	low, high := s.bounds.min, s.bounds.max
	low[3], high[3] = s.begin, s.end
	for i, n := range h.n {
		if n < 0 {
			low[i], high[i] = high[i], low[i]
		}
	}
	return s.cells > 0 && !(h.offset < dot(h.n, low) || h.offset > dot(h.n, high))
}

// axes are orthonormal and within the hyperplane: the first three columns of the reflection that takes n to
// the axis of t. For x, y or z = c they are y z t, x z t or x y t.
func (h hyperplane) axes() (axes [3]point) {
	for axis := range h.n {
		if h.n == unit(axis) {
			k := 0
			for other := range h.n {
				if other != axis {
					axes[k] = unit(other)
					k++
				}
			}
			return axes
		}
	}
	largest := 0.0
	for _, x := range h.n {
		largest = math.Max(largest, math.Abs(x))
	}
	v, square := h.n, 0.0
	for i := range v {
		v[i] /= largest
		square += v[i] * v[i]
	}
	v[3] += math.Copysign(math.Sqrt(square), v[3])
	square = dot(v, v)
	for i := range axes {
		axes[i] = unit(i)
		for j := range v {
			axes[i][j] -= 2 * v[i] * v[j] / square
		}
	}
	return axes
}

func unit(axis int) (p point) {
	p[axis] = 1
	return p
}
