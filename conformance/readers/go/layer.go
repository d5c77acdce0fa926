package main

import "math"

type point [4]float64

// A layer is a LAYR, or what a POSE makes of one.
type layer struct {
	time       float64
	points     []point
	rounded    bool // to binary32, but for the time
	attributes []attribute
}

func finite(numbers ...float64) bool {
	for _, x := range numbers {
		if math.IsInf(x, 0) || math.IsNaN(x) {
			return false
		}
	}
	return true
}

// positions reads an array of positions; the points have no time yet.
func (p *payload) positions(rule string) (points []point, rounded bool) {
	a := p.record()
	require(a.is(3, typeF32, typeF64) || a.is(3, typeI32) && p.head.has("grid"), a.offset,
		rule, "the positions have the wrong type")
	p.load(a)
	points = make([]point, a.rows)
	for i := range points {
		for axis := 0; axis < 3; axis++ {
			scalar := uint64(3*i + axis)
			if a.kind == typeI32 {
				k := int32(le.Uint32(a.data[4*scalar:]))
				points[i][axis] = p.head.grid.origin[axis] + float64(p.head.grid.step*float64(k))
			} else {
				points[i][axis] = a.f64(scalar)
			}
		}
	}
	return points, a.kind == typeF32
}

func (l *layer) setTime(time float64) {
	l.time = time
	for i := range l.points {
		l.points[i][3] = time
	}
}

func (f *file) readLayer(at chunk) *layer {
	p := f.open(at, "L4")
	time := p.f64()
	require(finite(time), at.offset, "L1", "the time is not finite")
	attributes := p.u32()
	p.zeros(4, "L6")
	l := &layer{}
	l.points, l.rounded = p.positions("L2")
	require(len(l.points) > 0, at.offset, "L3", "the layer has no vertices")
	l.setTime(time)
	l.attributes = p.attributes(attributes, map[uint8]uint64{ofVertices: uint64(len(l.points))}, "L5")
	p.end()
	return l
}

// readPose reads a POSE.
func (c *catalog) readPose(at chunk) *layer {
	require(c.head.has("pose"), at.offset, "K5", "the file does not name the feature pose")
	p := c.open(at, "K4")
	time := p.f64()
	require(finite(time), at.offset, "K1", "the time is not finite")
	distance := p.u64()
	var m [3][4]float64
	for row := range m {
		for column := range m[row] {
			m[row][column] = p.f64()
		}
		require(finite(m[row][:]...), at.offset, "K3", "the matrix is not finite")
	}
	p.end()

	base := c.posedLayer(distance, at)
	l := &layer{rounded: base.rounded, attributes: base.attributes, points: make([]point, len(base.points))}
	for i, q := range base.points {
		for row, n := range m {
			x := float64(float64(n[0]*q[0])+float64(n[1]*q[1])) + float64(n[2]*q[2]) + n[3]
			if l.rounded {
				x = float64(float32(x))
			}
			l.points[i][row] = x
		}
	}
	l.setTime(time)
	return l
}
