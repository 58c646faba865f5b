# Part of the build: the page into a C source of assets.h.
#   cmake -D PAGE=DIR -D MODULES=DIR -D ESBUILD=FILE -D GZIP=FILE -D LICENSE=FILE
#         -D NAME=TEXT -D OUT=DIR -P bundle.cmake
# or, of what that left in OUT, into lumview.html, which has all within:
#   cmake -D PAGE=DIR -D ESBUILD=FILE -D GZIP=FILE -D BASE64=FILE -D OUT=DIR
#         -D WASM=FILE -D SOURCES=DIR -D ALONE=FILE -P bundle.cmake
# or, of the modules, what a release keeps, into the folder KEEP:
#   cmake -D PAGE=DIR -D MODULES=DIR -D OUT=DIR -D KEEP=DIR -P bundle.cmake
# esbuild makes one script and one style of the page and of the modules that it
# imports. Their names have a hash of their content, by which browsers keep them.
cmake_minimum_required(VERSION 3.22)

# bundle_run(COMMAND...): a failure ends the build.
function(bundle_run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${OUT} RESULT_VARIABLE failed ERROR_VARIABLE why)
  if(failed)
    list(GET ARGN 0 program)
    message(FATAL_ERROR "${program}: ${failed}\n${why}")
  endif()
endfunction()

function(bundle_join)
  # Legal comments of modules would be a part of what licenses.txt has whole.
  bundle_run(${CMAKE_COMMAND} -E env NODE_PATH=${MODULES} ${ESBUILD} ${PAGE}/app.js ${PAGE}/style.css --bundle --minify
             --format=esm --target=es2022 --log-level=warning --charset=utf8 --legal-comments=none
             "--banner:js=/* Licences: /licenses.txt, or lumview --licenses */" --metafile=${OUT}/bundle.json
             --outdir=${OUT})
endfunction()

# bundle_key(NAME ENDING TYPE HTML): compressed, under a name that has its hash; the
# page asks for that.
function(bundle_key name ending type html)
  file(SHA256 ${OUT}/${name}${ending} hash)
  string(SUBSTRING ${hash} 0 16 key)
  string(REPLACE "\"/${name}${ending}\"" "\"/${name}-${key}${ending}\"" keyed "${${html}}")
  if("${keyed}" STREQUAL "${${html}}")
    message(FATAL_ERROR "index.html names no /${name}${ending}")
  endif()
  bundle_run(${GZIP} -9nkf ${OUT}/${name}${ending})
  set(${html} "${keyed}" PARENT_SCOPE)
  bundle_asset(/${name}-${key}${ending} ${OUT}/${name}${ending}.gz "${type}" true)
endfunction()

# bundle_asset(PATH FILE TYPE IS_KEPT): as one of those in assets.c.
function(bundle_asset path file type is_kept)
  file(READ ${file} bytes HEX)
  file(SIZE ${file} size)
  string(REGEX REPLACE "(..)" "\\\\x\\1" bytes "${bytes}")
  file(APPEND ${OUT}/assets.c "{\"${path}\", \"${type}\", \"${bytes}\", ${size}, ${is_kept}},\n")
endfunction()

# bundle_folder(FILE OUT): that of the module which a file is from; "" where it is
# the page's own.
function(bundle_folder file out)
  file(REAL_PATH ${PAGE} page)
  file(REAL_PATH ${MODULES} modules)
  file(REAL_PATH ${file} path BASE_DIRECTORY ${OUT})
  string(FIND ${path} ${page}/ in_page)
  string(FIND ${path} ${modules}/ in_modules)
  if(in_page EQUAL 0)
    set(folder "")
  elseif(path MATCHES "^(.*/node_modules/(@[^/]+/)?[^/]+)/")
    set(folder ${CMAKE_MATCH_1})
  elseif(in_modules EQUAL 0)
    string(LENGTH ${modules}/ length)
    string(SUBSTRING ${path} ${length} -1 rest)
    string(REGEX MATCH "^(@[^/]+/)?[^/]+" name ${rest})
    set(folder ${modules}/${name})
  else()
    message(FATAL_ERROR "${path} is in the page, and neither its own nor a module's: under which licence?")
  endif()
  set(${out} "${folder}" PARENT_SCOPE)
endfunction()

# bundle_folders(OUT): those of the modules that are in the page.
function(bundle_folders out)
  file(READ ${OUT}/bundle.json bundle)
  string(JSON count LENGTH "${bundle}" inputs)
  math(EXPR last "${count} - 1")
  set(folders "")
  foreach(i RANGE ${last})
    string(JSON input MEMBER "${bundle}" inputs ${i})
    bundle_folder(${input} found)
    list(APPEND folders ${found})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  list(SORT folders)
  set(${out} "${folders}" PARENT_SCOPE)
endfunction()

# bundle_permission(FOLDER OUT): a module's title and its licence.
function(bundle_permission folder out)
  file(READ ${folder}/package.json about)
  foreach(member IN ITEMS name version license)
    string(JSON ${member} GET "${about}" ${member})
  endforeach()
  file(GLOB files ${folder}/LICEN[SC]E*)
  if(NOT files)
    message(FATAL_ERROR "${folder}: there is no licence file to be shipped with it")
  endif()
  set(text "\n\n==== ${name} ${version} (${license})\n")
  foreach(file IN LISTS files)
    file(READ ${file} permission)
    string(APPEND text "\n${permission}")
  endforeach()
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

function(bundle_licenses)
  file(READ ${LICENSE} own)
  set(licenses "==== ${NAME}\n\n${own}")
  bundle_folders(folders)
  foreach(folder IN LISTS folders)
    bundle_permission(${folder} permission)
    string(APPEND licenses "${permission}")
  endforeach()
  execute_process(COMMAND ${ESBUILD} --version OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE)
  string(APPEND licenses "\n\n==== esbuild ${version}\n\nIt joined the script and the style of the page. What it writes "
                         "is under the licences\nabove, and not under its own.\n")
  file(WRITE ${OUT}/licenses.txt "${licenses}")
endfunction()

# bundle_add_permissions(FILE): those of what the module of WebAssembly has
# within: libraries, and those of the compiler, Debian's or zig's.
function(bundle_add_permissions file)
  set(texts zlib=${SOURCES}/zlib/LICENSE Zstandard=${SOURCES}/libzstd/LICENSE libyaml=${SOURCES}/libyaml/License
      ${WASM_LICENSES})
  foreach(text IN LISTS texts)
    string(REGEX MATCH "^([^=]*)=(.*)$" ignored ${text})
    file(READ ${CMAKE_MATCH_2} permission)
    file(APPEND ${file} "\n\n==== ${CMAKE_MATCH_1}\n\n${permission}")
  endforeach()
endfunction()

# bundle_replace(VARIABLE OLD NEW): its text has what is replaced.
function(bundle_replace variable old new)
  string(REPLACE "${old}" "${new}" text "${${variable}}")
  if("${text}" STREQUAL "${${variable}}")
    message(FATAL_ERROR "index.html has no ${old}")
  endif()
  set(${variable} "${text}" PARENT_SCOPE)
endfunction()

# bundle_head(OUT): the page, with its style and what unpacks the rest. Its
# policy lets it ask nobody for anything.
function(bundle_head out)
  bundle_run(${ESBUILD} ${PAGE}/boot.js --minify --format=esm --target=es2022 --log-level=warning --charset=utf8
             --outfile=${OUT}/boot.js)
  file(READ ${PAGE}/index.html html)
  file(READ ${OUT}/boot.js boot)
  file(READ ${OUT}/style.css style)
  file(READ ${PAGE}/icon.svg icon)
  string(STRIP "${icon}" icon)
  string(REPLACE "#" "%23" icon "${icon}")
  string(REPLACE "\"" "'" icon "${icon}")
  string(CONCAT policy "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; worker-src blob:; "
                       "style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'")
  set(charset "<meta charset=\"utf-8\">")
  bundle_replace(html "${charset}" "${charset}\n<meta http-equiv=\"Content-Security-Policy\" content=\"${policy}\">")
  bundle_replace(html "\"/icon.svg\"" "\"data:image/svg+xml,${icon}\"")
  bundle_replace(html "<link rel=\"stylesheet\" href=\"/style.css\">" "<style>${style}</style>")
  bundle_replace(html "<script type=\"module\" src=\"/app.js\"></script>" "<script type=\"module\">${boot}</script>")
  bundle_replace(html "</body>\n</html>\n" "")
  set(${out} "${html}" PARENT_SCOPE)
endfunction()

# Beside the module: the scripts of the page and of the worker, and licences.
function(bundle_alone)
  set(folder ${OUT}/alone)
  file(MAKE_DIRECTORY ${folder})
  bundle_run(${ESBUILD} ${PAGE}/worker.js --bundle --minify --format=iife --target=es2022 --log-level=warning
             --charset=utf8 --outfile=${folder}/worker.js)
  file(COPY ${OUT}/app.js ${OUT}/licenses.txt ${WASM} DESTINATION ${folder})
  bundle_add_permissions(${folder}/licenses.txt)
  set(parts "")
  foreach(name IN ITEMS app.js worker.js licenses.txt lumview.wasm)
    bundle_run(${GZIP} -9nkf ${folder}/${name})
    execute_process(COMMAND ${BASE64} INPUT_FILE ${folder}/${name}.gz OUTPUT_VARIABLE packed COMMAND_ERROR_IS_FATAL ANY)
    string(REPLACE "\n" "" packed "${packed}")
    string(APPEND parts "<script type=\"text/plain\" id=\"${name}\">${packed}</script>\n")
  endforeach()
  bundle_head(html)
  file(WRITE ${folder}/lumview.html "${html}${parts}</body>\n</html>\n")
  file(RENAME ${folder}/lumview.html ${ALONE})
endfunction()

# Of the modules, what is in the page and what tells their licences: with that and
# an esbuild the page is built without a network.
function(bundle_keep)
  bundle_folders(folders)
  file(REAL_PATH ${MODULES} modules)
  file(READ ${OUT}/bundle.json bundle)
  string(JSON count LENGTH "${bundle}" inputs)
  math(EXPR last "${count} - 1")
  foreach(i RANGE ${last})
    string(JSON input MEMBER "${bundle}" inputs ${i})
    file(REAL_PATH ${input} path BASE_DIRECTORY ${OUT})
    file(RELATIVE_PATH name ${modules} ${path})
    if(NOT name MATCHES "^\\.\\./")
      get_filename_component(folder ${KEEP}/${name} DIRECTORY)
      file(COPY ${path} DESTINATION ${folder})
    endif()
  endforeach()
  foreach(folder IN LISTS folders)
    file(RELATIVE_PATH name ${modules} ${folder})
    file(GLOB files ${folder}/package.json ${folder}/LICEN[SC]E*)
    file(COPY ${files} DESTINATION ${KEEP}/${name})
  endforeach()
endfunction()

if(KEEP)
  bundle_keep()
  return()
endif()
if(ALONE)
  bundle_alone()
  return()
endif()
file(REMOVE_RECURSE ${OUT})
file(MAKE_DIRECTORY ${OUT})
bundle_join()
bundle_licenses()
file(READ ${PAGE}/index.html page_html)
file(WRITE ${OUT}/assets.c "#include \"assets.h\"\nconst struct asset assets[] = {\n")
bundle_key(app .js "text/javascript; charset=utf-8" page_html)
bundle_key(style .css "text/css; charset=utf-8" page_html)
file(WRITE ${OUT}/index.html "${page_html}")
bundle_asset(/index.html ${OUT}/index.html "text/html; charset=utf-8" false)
bundle_asset(/icon.svg ${PAGE}/icon.svg "image/svg+xml" false)
bundle_asset(/licenses.txt ${OUT}/licenses.txt "text/plain; charset=utf-8" false)
file(APPEND ${OUT}/assets.c "};\nconst size_t assets_count = sizeof assets / sizeof assets[0];\n")
