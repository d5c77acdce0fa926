package main

func det3(a, b, c [3]float64) float64 {
	return a[0]*(b[1]*c[2]-b[2]*c[1]) - a[1]*(b[0]*c[2]-b[2]*c[0]) + a[2]*(b[0]*c[1]-b[1]*c[0])
}

func det4(a, b, c, d point) float64 {
	minor := func(p point, without int) (m [3]float64) {
		copy(m[:], p[:without])
		copy(m[without:], p[without+1:])
		return m
	}
	sum, sign := 0.0, 1.0
	for i := range a {
		sum += sign * a[i] * det3(minor(b, i), minor(c, i), minor(d, i))
		sign = -sign
	}
	return sum
}

// dot is rounded after every operation (rule X1): Go may fuse what is not converted.
func dot(n, p point) float64 {
	return float64(float64(n[0]*p[0])+float64(n[1]*p[1])) + float64(n[2]*p[2]) + float64(n[3]*p[3])
}
