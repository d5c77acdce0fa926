package main

import (
	"fmt"
	"math"
	"strconv"
	"strings"
)

// A double is printed as a string that is read back as the same number.
type double float64

func (d double) MarshalText() ([]byte, error) {
	return []byte(strings.TrimPrefix(strconv.FormatFloat(float64(d), 'g', 17, 64), "+")), nil
}

// A checksum is printed as 8 hexadecimal digits.
type checksumText uint32

func (c checksumText) MarshalText() ([]byte, error) {
	return []byte(fmt.Sprintf("%08x", uint32(c))), nil
}

func doubles(numbers []float64) (printed []double) {
	for _, x := range numbers {
		printed = append(printed, double(x))
	}
	return printed
}

// limits are minimum and maximum of the first coordinates of a box, nil where it is empty.
func (b box) limits(coordinates int) (min, max []double) {
	if math.IsInf(b.min[0], 1) {
		return nil, nil
	}
	return doubles(b.min[:coordinates]), doubles(b.max[:coordinates])
}
