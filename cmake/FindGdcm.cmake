# Gdcm::Gdcm, GDCM's libraries for the samples of DICOM images. Debian's package configuration needs
# packages that programs do not.
find_path(Gdcm_INCLUDE_DIR gdcmImage.h PATH_SUFFIXES gdcm-3.0)
find_library(Gdcm_LIBRARY gdcmMSFF)
find_library(Gdcm_DSED_LIBRARY gdcmDSED)
find_library(Gdcm_DICT_LIBRARY gdcmDICT)
find_library(Gdcm_COMMON_LIBRARY gdcmCommon)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Gdcm REQUIRED_VARS
  Gdcm_LIBRARY Gdcm_DSED_LIBRARY Gdcm_DICT_LIBRARY Gdcm_COMMON_LIBRARY Gdcm_INCLUDE_DIR)
if(Gdcm_FOUND AND NOT TARGET Gdcm::Gdcm)
  add_library(Gdcm::Gdcm UNKNOWN IMPORTED)
  set_target_properties(Gdcm::Gdcm PROPERTIES
    IMPORTED_LOCATION "${Gdcm_LIBRARY}"
    INTERFACE_LINK_LIBRARIES "${Gdcm_DSED_LIBRARY};${Gdcm_DICT_LIBRARY};${Gdcm_COMMON_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${Gdcm_INCLUDE_DIR}")
endif()
mark_as_advanced(Gdcm_INCLUDE_DIR Gdcm_LIBRARY Gdcm_DSED_LIBRARY Gdcm_DICT_LIBRARY
  Gdcm_COMMON_LIBRARY)
