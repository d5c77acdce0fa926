package main

import "math"

// A cut is the slice of a body, made by marching tetrahedra.
type cut struct {
	hyperplane
	closed  bool // points on the hyperplane are above: at the last time of the body
	axes    [3]point
	flipped bool

	points       map[edge]bool
	triangles    int
	volume, area float64
	box          box
}

// A vertexID is the same for a vertex of two slabs: the number of the slab in its body, times 2^32, and
// that of the vertex in it, where an upper layer is the lower layer of the next slab.
type vertexID uint64

// An edge is what a point of the slice comes from, the end above first. A vertex is both ends.
type edge [2]vertexID

// A corner of a triangle is in the axes of the slice.
type corner struct {
	from edge
	at   [3]float64
}

// corners are those of the polygon that is cut from a cell, as edges of the cell, by the number of vertices
// above, which come first.
var corners = [...][][2]int{
	1: {{0, 1}, {0, 3}, {0, 2}},
	2: {{1, 2}, {1, 3}, {0, 3}, {0, 2}},
	3: {{2, 3}, {1, 3}, {0, 3}},
}

func newCut(h hyperplane, axes [3]point, flipped bool) *cut {
	return &cut{hyperplane: h, axes: axes, flipped: flipped, points: map[edge]bool{}, box: emptyBox()}
}

// add cuts the cells of a slab, which has a number in its body.
func (c *cut) add(s *slab, number uint64) {
	values := make([]float64, len(s.points))
	for v, p := range s.points {
		values[v] = dot(c.n, p)
	}
	for i := uint64(0); i < s.cellCount; i++ {
		cell, above := c.sorted(s.cell(i), values)
		if above == 0 || above == 4 {
			continue
		}
		var polygon []corner
		for _, e := range corners[above] {
			polygon = append(polygon, c.corner(s, number, values, cell[e[0]], cell[e[1]]))
		}
		for i := 2; i < len(polygon); i++ {
			c.triangle(polygon[0], polygon[i-1], polygon[i])
		}
	}
}

func (c *cut) isAbove(value float64) bool { return value > c.offset || c.closed && value == c.offset }

// sorted is an even permutation of the vertices of a cell with those that are above first.
func (c *cut) sorted(cell []uint32, values []float64) (sorted [4]uint32, above int) {
	odd := false
	for i, v := range cell {
		if c.isAbove(values[v]) {
			odd = odd != ((i-above)%2 == 1)
			sorted[above] = v
			above++
		}
	}
	next := above
	for _, v := range cell {
		if !c.isAbove(values[v]) {
			sorted[next] = v
			next++
		}
	}
	if odd && above < 3 {
		sorted[2], sorted[3] = sorted[3], sorted[2]
	} else if odd {
		sorted[0], sorted[1] = sorted[1], sorted[0]
	}
	return sorted, above
}

func (s *slab) id(number uint64, v uint32) vertexID {
	if uint64(v) >= s.firstUpper() {
		return vertexID((number+1)<<32 | uint64(v) - s.firstUpper())
	}
	return vertexID(number<<32 | uint64(v))
}

// corner cuts an edge between a vertex above and one that is not.
func (c *cut) corner(s *slab, number uint64, values []float64, above, below uint32) corner {
	from := edge{s.id(number, above), s.id(number, below)}
	p := s.points[above]
	switch c.offset {
	case values[above]:
		from[1] = from[0]
	case values[below]:
		from[0] = from[1]
		p = s.points[below]
	default:
		w := (c.offset - values[below]) / (values[above] - values[below])
		for i, x := range s.points[below] {
			p[i] = p[i]*w + x*(1-w)
		}
	}
	return corner{from, [3]float64{dot(c.axes[0], p), dot(c.axes[1], p), dot(c.axes[2], p)}}
}

// triangle adds a triangle, unless it has lost a corner.
func (c *cut) triangle(i, j, k corner) {
	if i.from == j.from || j.from == k.from || k.from == i.from {
		return
	}
	if c.flipped {
		j, k = k, j
	}
	for _, corner := range [...]corner{i, j, k} {
		c.points[corner.from] = true
		c.box.add(point{corner.at[0], corner.at[1], corner.at[2]})
	}
	var u, v [3]float64
	for axis := range u {
		u[axis], v[axis] = j.at[axis]-i.at[axis], k.at[axis]-i.at[axis]
	}
	c.triangles++
	c.volume += det3(i.at, j.at, k.at) / 6
	c.area += math.Hypot(math.Hypot(u[1]*v[2]-u[2]*v[1], u[2]*v[0]-u[0]*v[2]), u[0]*v[1]-u[1]*v[0]) / 2
}

func (c *cut) answer(name string) bodySlice {
	b := bodySlice{
		Name: name, Points: len(c.points), Triangles: c.triangles, Volume: double(c.volume), Area: double(c.area),
	}
	b.Min, b.Max = c.box.limits(3)
	return b
}
