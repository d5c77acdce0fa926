meta:
  id: zstd_frame
  title: One Zstandard frame
  license: Apache-2.0
  ks-version: 0.11
  endian: le
  bit-endian: le
doc: |
  The frame and its blocks, without what is in these: enough to see that a frame is whole and alone
  (A10) and what content size it declares (A11), which decompressors do not tell.
doc-ref: RFC 8878, section 3.1.1

seq:
  - id: magic
    contents: [0x28, 0xb5, 0x2f, 0xfd]
  - id: dictionary_id_flag
    type: b2
  - id: has_checksum
    type: b1
  - id: reserved
    type: b1
    valid: false
  - id: unused
    type: b1
  - id: is_single_segment
    type: b1
  - id: content_size_flag
    type: b2
  - id: window_descriptor
    type: u1
    if: not is_single_segment
  - id: dictionary_id
    type: u1
    repeat: expr
    repeat-expr: 'dictionary_id_flag == 3 ? 4 : dictionary_id_flag'
    valid: 0
  - id: content_size_stored
    type:
      switch-on: content_size_flag
      cases:
        0: u1
        1: u2
        2: u4
        3: u8
    if: has_content_size
  - id: blocks
    type: block
    repeat: until
    repeat-until: _.is_last
  - id: checksum
    type: u4
    if: has_checksum
  - id: end_of_frame
    size: 0
    valid:
      expr: _io.eof

instances:
  has_content_size:
    value: content_size_flag > 0 or is_single_segment
  content_size:
    value: 'content_size_flag == 1 ? content_size_stored + 256 : content_size_stored'
    if: has_content_size

types:
  block:
    seq:
      - id: is_last
        type: b1
      - id: type
        type: b2
        valid:
          max: 2
        doc: 0 raw, 1 one byte repeated, 2 compressed.
      - id: len_block
        type: b21
      - id: body
        size: 'type == 1 ? 1 : len_block'
