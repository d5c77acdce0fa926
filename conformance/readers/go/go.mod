module t4d_reader

go 1.19
