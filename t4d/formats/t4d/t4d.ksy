meta:
  id: t4d
  title: .t4d 4D mesh, version 1.0
  file-extension: t4d
  license: Apache-2.0
  ks-version: 0.11
  encoding: UTF-8
  endian: le
doc: |
  A `.t4d` file holds 4D meshes: each is the boundary of a moving solid in space-time (x, y, z, t),
  made of tetrahedra and cut into slabs in time order. SPEC.md beside this file is the
  specification; where the two differ, SPEC.md applies.

  Two ways in:

  * From the front: `header`, then `chunks`, one after the other.
  * By index, where `header.has_index`: `footer`, from there `index_chunk` and `done_chunk`. Each
    record of INDX gives a slab and its parts as offsets; a `chunk` is parsed there, from the file at that
    offset or from a buffer that holds nothing but it.

  All but `header` are instances, so that nothing is read before it is asked for. The types `chunk`,
  `file_header` and `file_footer` need no root and can be used alone.

  `-rule` names the rule of SPEC.md that a `valid` or `contents` checks. An attribute named
  `end_of_...` takes no bytes; it holds what can be checked only there, mostly that no bytes are
  left. Reading past the end of a payload breaks the rule that says how it ends (N11, L4, S9, D4,
  I1). Lengths are held against what is left of the stream before they are used: some runtimes cut
  them to 32 bits.

  What a grammar cannot say is left to whoever uses it:

  * checksums (H2, C4, C5, F2), the length and places in the footer (F3, F4, F5);
  * the order and number of chunks (O1 to O6), unknown critical chunks (C8), the critical bit of
    private chunks;
  * decompression (A10 to A13), UTF-8 (M2, T4), JSON (M3 to M10);
  * whatever compares numbers of several chunks or rows (T6, T7, N4 to N9, N12, S2 to S4, S7, S8, P1
    to P4, D1, D2, D5 to D8, I2, I3).
doc-ref: SPEC.md

seq:
  - id: header
    type: file_header

instances:
  chunks:
    doc: All chunks from the front, up to INDX, or to DONE in a file without index.
    pos: 24
    type: chunk
    repeat: until
    repeat-until: '_.header.type.text == (header.has_index ? "INDX" : "DONE")'
  footer:
    pos: _io.size - 40
    type: file_footer
    if: header.has_index
  index_chunk:
    pos: footer.ofs_index
    type: chunk
    if: header.has_index
  done_chunk:
    pos: footer.ofs_done
    type: chunk
    if: header.has_index

types:

  file_header:
    doc-ref: SPEC.md, "File header"
    seq:
      - id: signature
        contents: [0x89, T4D, 0x0d, 0x0a, 0x1a, 0x0a]
        -rule: H1
      - id: version_major
        type: u2
        valid: 1
        -rule: H3
      - id: version_minor
        type: u2
      - id: flags
        type: u4
        valid:
          expr: _ <= 1
        -rule: H4
        doc: Bit 0 says that the file has an index; the other bits are reserved.
      - id: reserved
        contents: [0, 0, 0, 0]
        -rule: H5
      - id: checksum
        type: u4
        doc: CRC-32C of bytes 0 to 19 (H2).
    instances:
      has_index:
        value: flags == 1

  file_footer:
    doc: The last 40 bytes of a file with index.
    doc-ref: SPEC.md, "Footer"
    seq:
      - id: ofs_index
        type: u8
      - id: ofs_done
        type: u8
      - id: len_file
        type: u8
      - id: reserved
        size: 4
      - id: checksum
        type: u4
        doc: CRC-32C of bytes 0 to 27 of the footer (F2).
      - id: end_signature
        contents: [0x0a, 0x1a, 0x0a, 0x0d, D4T, 0x89]
        -rule: F1
      - id: end_of_footer
        size: 0
        valid:
          expr: reserved == [0, 0, 0, 0]
        -rule: F6
        doc: After the end signature, so that a truncated file is reported as such.

  chunk:
    doc-ref: SPEC.md, "Chunks"
    seq:
      - id: header
        type: chunk_header
        valid:
          expr: _.len_payload <= _io.size - _io.pos and _.len_padding <= _io.size - _io.pos - _.len_payload
        -rule: C3
      - id: payload
        size: header.len_payload
        type:
          switch-on: header.type.text
          cases:
            '"HEAD"': head
            '"CONN"': conn
            '"LAYR"': layr
            '"SLAB"': slab
            '"DONE"': done
            '"INDX"': indx
        doc: The payload of an unknown type is left as bytes.
      - id: padding
        type: u1
        repeat: expr
        repeat-expr: header.len_padding
        valid: 0
        -rule: C6

  chunk_header:
    seq:
      - id: type
        type: chunk_type
        size: 4
      - id: flags
        type: u4
        valid:
          expr: _ <= 1
        -rule: C2
      - id: len_payload
        type: u8
        doc: In bytes, without padding.
      - id: payload_checksum
        type: u4
        doc: CRC-32C of the payload, without padding (C5).
      - id: header_checksum
        type: u4
        doc: CRC-32C of bytes 0 to 19 of this header (C4).
      - id: end_of_header
        size: 0
        valid:
          expr: is_critical or not is_known
        -rule: C7
    instances:
      is_critical:
        value: flags == 1
        doc: A reader must refuse the file if it does not know the type (C8).
      is_known:
        value: >-
          type.text == "HEAD" or type.text == "CONN" or type.text == "LAYR" or type.text == "SLAB"
          or type.text == "DONE" or type.text == "INDX"
      len_padding:
        value: (8 - len_payload % 8) % 8
      len_chunk:
        value: 24 + len_payload + len_padding
        doc: The distance to the next chunk. May overflow unless `len_payload` has been checked.

  chunk_type:
    seq:
      - id: characters
        type: u1
        repeat: expr
        repeat-expr: 4
        valid:
          expr: (_ >= 0x30 and _ <= 0x39) or (_ >= 0x41 and _ <= 0x5a) or (_ >= 0x61 and _ <= 0x7a)
        -rule: C1
        doc: ASCII digits and letters.
    instances:
      text:
        pos: 0
        size: 4
        type: str
        encoding: ASCII

  array_record:
    doc: Rows of a fixed number of scalars of one type, row after row.
    doc-ref: SPEC.md, "Arrays"
    seq:
      - id: scalar_type
        type: u1
        enum: scalar_type
        valid:
          in-enum: true
        -rule: A1
      - id: num_components
        type: u1
        valid:
          min: 1
        -rule: A2
      - id: codec
        type: u1
        enum: codec
        valid:
          in-enum: true
        -rule: A3
      - id: reserved
        contents: [0, 0, 0, 0, 0]
        -rule: A4
      - id: num_rows
        type: u8
        valid:
          expr: _ != 0 or codec == codec::raw
        -rule: A8
      - id: len_stored
        type: u8
        valid:
          max: _io.size - _io.pos
        -rule: A5
        doc: Without padding.
      - id: stored
        size: len_stored
        valid:
          expr: codec != codec::raw or (len_stored % len_row == 0 and len_stored / len_row == num_rows)
        -rule: A7
        type:
          switch-on: codec
          cases:
            'codec::raw': scalars(scalar_type, num_rows * num_components)
        doc: |
          Codec 0: the numbers. Codec 1: one Zstandard frame; its content is the array transposed:
          byte j of row i is byte j x num_rows + i of the content. Put back in order, it can be
          parsed as `scalars`.

          The rule is stored bytes = rows x size of a row, without overflow.
      - id: padding
        type: u1
        repeat: expr
        repeat-expr: (8 - len_stored % 8) % 8
        valid: 0
        -rule: A6
      - id: end_of_record
        size: 0
        valid:
          expr: codec == codec::raw or num_rows <= len_stored * 1024 / len_row
        -rule: A9
        doc: Cannot overflow, since the stored bytes exist.
    instances:
      len_scalar:
        value: >-
          scalar_type.to_i <= 2 ? 1 : scalar_type.to_i <= 4 ? 2 :
          (scalar_type.to_i <= 6 or scalar_type == scalar_type::f32) ? 4 : 8
      len_row:
        value: num_components * len_scalar
        doc: In bytes.

  scalars:
    doc: Numbers without a header, from the beginning of the stream.
    params:
      - id: scalar_type
        type: u1
        enum: scalar_type
      - id: num_values
        type: u8
    instances:
      values:
        pos: 0
        type:
          switch-on: scalar_type
          cases:
            'scalar_type::u8': u1
            'scalar_type::s8': s1
            'scalar_type::u16': u2
            'scalar_type::s16': s2
            'scalar_type::u32': u4
            'scalar_type::s32': s4
            'scalar_type::u64': u8
            'scalar_type::s64': s8
            'scalar_type::f32': f4
            'scalar_type::f64': f8
        repeat: expr
        repeat-expr: num_values

  attribute:
    doc: Named numbers for each vertex or each cell of a slab.
    doc-ref: SPEC.md, "Attributes"
    seq:
      - id: domain
        type: u1
        enum: domain
        valid:
          in-enum: true
        -rule: T1
      - id: reserved
        contents: [0, 0, 0]
        -rule: T2
      - id: len_name
        type: u4
        valid:
          min: 1
          max: 255
        -rule: T3
      - id: name_bytes
        size: len_name
        doc: UTF-8; `name` is its text. How invalid UTF-8 is decoded depends on the language.
      - id: padding
        type: u1
        repeat: expr
        repeat-expr: (8 - len_name % 8) % 8
        valid: 0
        -rule: T5
      - id: values
        type: array_record
    instances:
      name:
        value: name_bytes.to_s("UTF-8")

  head:
    doc: What the file is, one JSON object; head.schema.json describes it.
    doc-ref: SPEC.md, "HEAD"
    seq:
      - id: end_of_head
        size: 0
        valid:
          expr: _io.size <= 16777216
        -rule: M1
      - id: json
        size-eos: true
        doc: UTF-8 without byte order mark.

  conn:
    doc: |
      Everything of a slab except its positions. The vertices of a slab are, in this order: lower
      layer, interior vertices that are stored, means, upper layer.
    doc-ref: SPEC.md, "CONN"
    seq:
      - id: num_vertices
        type: u4
        doc: Of the slab.
      - id: num_lower
        type: u4
        valid:
          max: num_vertices
        -rule: N1
        doc: Vertices of the lower layer.
      - id: num_upper
        type: u4
        valid:
          max: num_vertices - num_lower
        -rule: N1
        doc: Vertices of the upper layer.
      - id: num_means
        type: u4
        valid:
          max: num_vertices - num_lower - num_upper
        -rule: N1
      - id: num_attributes
        type: u4
        valid:
          max: _io.size / 40
        -rule: N11
        doc: Each takes at least 40 bytes.
      - id: reserved
        contents: [0, 0, 0, 0]
        -rule: N2
      - id: cells
        type: array_record
        valid:
          expr: _.scalar_type == scalar_type::u32 and _.num_components == 4
        -rule: N3
        doc: Four indices of vertices of the slab, from 0.
      - id: mean_sizes
        type: array_record
        if: num_means > 0
        valid:
          expr: _.scalar_type == scalar_type::u32 and _.num_components == 1 and _.num_rows == num_means
        -rule: N6
        doc: How many sources each mean has.
      - id: mean_sources
        type: array_record
        if: num_means > 0
        valid:
          expr: _.scalar_type == scalar_type::u32 and _.num_components == 1
        -rule: N6
        doc: The sources of all means, those of the first mean first.
      - id: attributes
        type: attribute
        repeat: expr
        repeat-expr: num_attributes
        valid:
          expr: _.domain == domain::cell
        -rule: N10
      - id: end_of_conn
        size: 0
        valid:
          expr: _io.eof
        -rule: N11
    instances:
      num_stored:
        value: num_vertices - num_lower - num_upper - num_means
        doc: Interior vertices that are not means; the SLAB has their positions and times.

  layr:
    doc: The vertices of one layer.
    doc-ref: SPEC.md, "LAYR"
    seq:
      - id: time
        type: f8
        valid:
          expr: _ - _ == 0
        -rule: L1
        doc: Of all these vertices. The difference is 0 for every finite number, and NaN otherwise.
      - id: positions
        type: array_record
        valid:
          expr: >-
            (_.scalar_type == scalar_type::f32 or _.scalar_type == scalar_type::f64)
            and _.num_components == 3
        -rule: L2
      - id: end_of_positions
        size: 0
        valid:
          expr: positions.num_rows > 0
        -rule: L3
      - id: end_of_layr
        size: 0
        valid:
          expr: _io.eof
        -rule: L4

  slab:
    doc: The part of a body between two times.
    doc-ref: SPEC.md, "SLAB"
    seq:
      - id: time_begin
        type: f8
        valid:
          expr: _ - _ == 0
        -rule: S1
      - id: time_end
        type: f8
        valid:
          expr: _ - _ == 0 and _ >= time_begin
        -rule: S1
      - id: ofs_connectivity
        type: u8
        doc: Of a CONN.
      - id: ofs_lower
        type: u8
        doc: Of a LAYR, 0 for an empty layer.
      - id: ofs_upper
        type: u8
        doc: Of a LAYR, 0 for an empty layer.
      - id: body
        type: u4
      - id: num_attributes
        type: u4
        valid:
          max: _io.size / 40
        -rule: S9
        doc: Each takes at least 40 bytes.
      - id: positions
        type: array_record
        valid:
          expr: >-
            (_.scalar_type == scalar_type::f32 or _.scalar_type == scalar_type::f64)
            and _.num_components == 3
        -rule: S5
        doc: Of the interior vertices that are not means.
      - id: times
        type: array_record
        valid:
          expr: >-
            _.scalar_type == scalar_type::f64 and _.num_components == 1
            and _.num_rows == positions.num_rows
        -rule: S6
      - id: attributes
        type: attribute
        repeat: expr
        repeat-expr: num_attributes
      - id: end_of_slab
        size: 0
        valid:
          expr: _io.eof
        -rule: S9

  done:
    doc: The end mark. A file with a valid DONE has all its slabs.
    doc-ref: SPEC.md, "DONE"
    seq:
      - id: num_chunks
        type: u8
        doc: Before this one.
      - id: num_bodies
        type: u4
        valid:
          expr: _io.size % 88 == 16 and _ == _io.size / 88
        -rule: D4
        doc: The payload takes 16 + 88 x num_bodies bytes.
      - id: reserved
        contents: [0, 0, 0, 0]
        -rule: D3
      - id: bodies
        type: body
        repeat: expr
        repeat-expr: num_bodies

  body:
    seq:
      - id: num_slabs
        type: u8
        valid:
          min: 1
        -rule: D5
      - id: num_vertices
        type: u8
        doc: Each once, those of all slabs, less the lower layers of all but the first.
      - id: num_cells
        type: u8
      - id: time_begin
        type: f8
      - id: time_end
        type: f8
      - id: minimum
        type: f8
        repeat: expr
        repeat-expr: 3
        doc: Of x, y, z of the stored vertices; +infinity without one.
      - id: maximum
        type: f8
        repeat: expr
        repeat-expr: 3

  indx:
    doc: Where the slabs are, in the order of the file.
    doc-ref: SPEC.md, "INDX"
    seq:
      - id: num_slabs
        type: u8
        valid:
          expr: _io.size % 64 == 8 and _ == _io.size / 64
        -rule: I1
        doc: The payload takes 8 + 64 x num_slabs bytes.
      - id: slabs
        type: slab_record
        repeat: expr
        repeat-expr: num_slabs

  slab_record:
    seq:
      - id: ofs_slab
        type: u8
      - id: len_slab
        type: u8
        doc: Of the chunk, with header and padding.
      - id: time_begin
        type: f8
      - id: time_end
        type: f8
      - id: ofs_connectivity
        type: u8
      - id: ofs_lower
        type: u8
      - id: ofs_upper
        type: u8
      - id: body
        type: u4
      - id: reserved
        contents: [0, 0, 0, 0]
        -rule: I4

enums:

  scalar_type:
    1: u8
    2: s8
    3: u16
    4: s16
    5: u32
    6: s32
    7: u64
    8: s64
    9: f32
    10: f64

  codec:
    0: raw
    1: zstd

  domain:
    1:
      id: vertex
      doc: A row for each vertex of the slab, means included.
    2:
      id: cell
      doc: A row for each cell of the slab.
