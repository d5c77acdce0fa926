package main

import "math"

// A box holds points. Without any, its minimum is +infinity and its maximum -infinity.
type box struct{ min, max point }

func emptyBox() (b box) {
	for i := range b.min {
		b.min[i], b.max[i] = math.Inf(1), math.Inf(-1)
	}
	return b
}

func (b *box) add(p point) { b.join(box{p, p}) }

func (b *box) join(other box) {
	for i := range b.min {
		if other.min[i] < b.min[i] {
			b.min[i] = other.min[i]
		}
		if other.max[i] > b.max[i] {
			b.max[i] = other.max[i]
		}
	}
}

// space is the box without its times.
func (b box) space() box {
	b.min[3], b.max[3] = 0, 0
	return b
}
