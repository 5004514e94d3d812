var _=class extends Error{name="FormatError"},g=class extends Error{name="UnsupportedError"};var Te=class extends Error{name="FileChangedError"},B=class extends Error{constructor(t,r){super(t);this.status=r}status;name="TransportError"},Rr=16,Ce=class n{constructor(e,t,r,o){this.url=e;this.byteCount=t;this.version=r;this.first=o}url;byteCount;version;first;static async open(e,t){let r=await Mr(e,{Range:`bytes=0-${Rr-1}`},t),{range:o,size:s}=S1(r);if(r.status===416&&s===0)return await Qe(r),new n(e,0,E1(r),new Uint8Array(0));if(r.status===200)throw await Qe(r),new g("The server does not answer requests for ranges of a file, which the player needs: nginx and Apache do, python3 -m http.server does not.");try{if(Tr(r),s===void 0||!o||o[0]!==0||o[1]!==Math.min(Rr,s)-1)throw new B("The server does not tell the size of the file, or answered with another range",206)}catch(a){throw await Qe(r),a}let i=await Cr(r,o[1]+1,t);return new n(e,s,E1(r),i)}async read(e,t,r){let o=e+t-1;if(!(e>=0&&t>=0&&o<this.byteCount))throw new RangeError(`bytes ${e} to ${o} of a file of ${this.byteCount}`);if(o<this.first.length)return this.first.slice(e,e+t);if(t===0)return new Uint8Array(0);let s=Ar(this.version.etag)?{"If-Range":this.version.etag}:void 0,i=await Mr(this.url,{Range:`bytes=${e}-${o}`,...s},r);try{this.checkVersion(i),Tr(i),this.checkRange(i,e,o)}catch(a){throw await Qe(i),a}return Cr(i,t,r)}checkVersion(e){let{status:t}=e;if(t!==200&&t!==206&&t!==412&&t!==416)return;let{etag:r,lastModified:o}=E1(e),{size:s}=S1(e),i=r!==null&&r!==this.version.etag||o!==null&&this.version.lastModified!==null&&o!==this.version.lastModified||s!==void 0&&s!==this.byteCount,a=t===200&&Ar(this.version.etag)&&r!==this.version.etag;if(i||a||(t===412||t===416))throw new Te("The file on the server has changed since it was opened")}checkRange(e,t,r){let{range:o}=S1(e);if(o?.[0]!==t||o[1]!==r){let s=o?`bytes ${o[0]} to ${o[1]}`:"no range";throw new B(`The server answered with ${s} where bytes ${t} to ${r} were asked for`,206)}}};function Ar(n){return n!==null&&n.startsWith('"')}function E1({headers:n}){return{etag:n.get("ETag"),lastModified:n.get("Last-Modified")}}function S1({headers:n}){let e=/^bytes (?:(\d{1,15})-(\d{1,15})|\*)\/(?:(\d{1,15})|\*)$/u.exec(n.get("Content-Range")??"");return{range:e?.[1]===void 0?void 0:[Number(e[1]),Number(e[2])],size:e?.[3]===void 0?void 0:Number(e[3])}}async function Mr(n,e,t){try{return await fetch(n,{headers:e,cache:"no-store",signal:t??null})}catch{throw Or(t)}}function Or(n){return n?.aborted?n.reason:new B("The connection to the server failed or was cut")}function Tr({status:n}){if(n!==206)throw new B(`The server answered ${n} where a part of the file was asked for`,n)}async function Qe(n){await n.body?.cancel().catch(()=>{})}async function Cr(n,e,t){let r=await R1(n,e).catch(()=>{throw Or(t)});if(r.length!==e){let o=r.length>e?"more":r.length;throw new B(`The server sent ${o} bytes where ${e} were asked for`)}return r}async function R1(n,e){let t=[],r=0,o=n.body?.getReader();for(let a=await o?.read();a&&!a.done;a=await o?.read())if(t.push(a.value),r+=a.value.length,r>e){await o?.cancel().catch(()=>{});break}if(t.length===1)return t[0];let s=new Uint8Array(r),i=0;for(let a of t)s.set(a,i),i+=a.length;return s}var A=class extends Error{name="FilmFileError"},Fi=["lfold","glb","quilt"],Pr=65536,Ui=4096,Li=1024,Nr=4096;function Fr(n,e){if(typeof n!="object"||n===null||Array.isArray(n))throw new A(`${e}: an object was expected.`);return n}function Ur(n,e,t){if(typeof n!="string"||n===""||n.length>t)throw new A(`${e}: a text of 1 to ${t} characters was expected.`);return n}function A1(n,e,[t,r]){if(typeof n!="number"||!Number.isInteger(n)||n<t||n>r)throw new A(`${e}: a whole number of ${t} to ${r} was expected.`);return n}function Ii(n,e){let t=Ur(n,"film.json, url",Ui),r=new URL(e);if(!(!/^[a-z][a-z0-9+.-]*:/i.test(t)&&!/^\s|[\\\u0000-\u001f]/.test(t)&&!t.startsWith("//"))||!URL.canParse(t,r))throw new A("film.json, url: a path relative to the page was expected.");let s=new URL(t,r);if(s.origin!==r.origin||s.username!==r.username||s.password!==r.password)throw new A("film.json, url: the film must come from the page's own server.");return s.hash="",s.href}function Bi(n){let e=Fr(n,"film.json, quilt"),t=e.aspect;if(typeof t!="number"||!(t>=.01&&t<=100))throw new A("film.json, quilt.aspect: a number of 0.01 to 100 was expected.");return{columns:A1(e.columns,"film.json, quilt.columns",[1,Nr]),rows:A1(e.rows,"film.json, quilt.rows",[1,Nr]),aspect:t}}function Di(n,e){let t;try{t=JSON.parse(n)}catch{throw new A("film.json: JSON was expected.")}let r=Fr(t,"film.json"),o=Fi.find(i=>i===r.kind);if(o===void 0)throw new A("film.json, kind: lfold, glb or quilt was expected.");let s={kind:o,url:Ii(r.url,e),name:Ur(r.name,"film.json, name",Li),bytes:A1(r.bytes,"film.json, bytes",[0,Number.MAX_SAFE_INTEGER])};return o==="quilt"?{...s,quilt:Bi(r.quilt)}:s}async function Lr(n){let e=()=>{throw new A("film.json, which names the film, cannot be reached.")},t=await fetch(n,{cache:"no-store"}).catch(e);if(!t.ok)throw new A(`film.json, which names the film: the server answered ${t.status}.`);let r=await R1(t,Pr).catch(e);if(r.length>Pr)throw new A("film.json is longer than any that names a film.");return Di(new TextDecoder().decode(r),n)}var Oe={constants:{NONE:4294967295,WORKGROUP:64,DEPTH_BITS_LEFT_OUT:10,SUM_WORKGROUP:256,MAX_GROUPS:65535,NODE_HEADER_WORDS:12,LEVELS:9,BOX_VALUES:0,BOX_CONSTANT:1,BOX_BLOCKS:2,KEYFRAME_SAMPLES:0,KEYFRAME_BLOCKS:1,DOMAIN_LOG:0,DOMAIN_LINEAR:1,DOMAIN_INVERSE:2,CONTEXT_NODE:0,CONTEXT_PLANES:40,CONTEXT_CODED:364,CONTEXT_LAST:460,CONTEXT_LAST_BITS:844,CONTEXT_LEVELS:866,CONTEXT_PALETTE_SIZE:2162,CONTEXT_PALETTE_COLOR:2166,CONTEXT_ROW:2167,CONTEXT_PIXEL:2169,CONTEXT_LATER_FRAME:2185,CONTEXT_LATER_ROW:2187,CONTEXT_LATER_PIXEL:2189,SUM_CLASSES_AT:97,SCAN_AT:109,CLUSTERS_AT:1469,OCTAVE_AT:3674,ROOTS_AT:3690,OFFSETS_AT:3699,SCRATCH_WORDS:4848,PASS_ITERATIONS:5e3,STEP_ITERATIONS:12,SLICE_WORKGROUP:256,SLICE_COLUMNS:1024,RUN_JOINS:65536,RUN_FIRST:131072,RUN_LENGTH_BITS:18,WINNER_AFTER:256,WINNER_BEFORE:512,WINNER_OWN:1024,LIGHT_GLOSS:1,LIGHT_TRACED:2,SHOWN_HOLE:1,SHOWN_OPTICAL:2,SHOWN_GLOSS:3,EROSION_REACH:2,EROSION_TOLERANCE:256,MOVE_BITS:8},structs:[{name:"Unit",members:["picture: u32","width: u32","height: u32","stride: u32","window: u32","domain: u32","base: u32","scale: u32"]},{name:"Chunk",members:["first_record: u32","record_count: u32","weights_at: u32","weight_count: u32"]},{name:"Record",members:["frame: u32","at: u32","first: u32","count: u32","work: u32","coding: u32"]},{name:"BoxRow",members:["x: u32","y: u32","width: u32","height: u32","at: u32","coding: u32","end: u32"]},{name:"Item",members:["unit: u32","chunk: u32","next: u32","frame: u32","key: u32"]},{name:"State",members:["key: u32","frame: u32","weight: u32"]},{name:"Job",members:["unit: u32","end: u32","record: u32","next: u32","weight: u32"]},{name:"Dispatch",members:["x: u32","y: u32","z: u32","part_x: u32","part_y: u32","part_z: u32"]},{name:"DepthJob",members:["picture: u32","stride: u32","left: u32","top: u32","width: u32","table: u32","ray_length: u32","ray_length_pitch: u32","output: u32","pitch: u32","end: u32"]},{name:"PyramidJob",members:["below: u32","below_pitch: u32","below_width: u32","below_height: u32","left: u32","top: u32","width: u32","output: u32","pitch: u32","limit: u32","end: u32"]},{name:"Scene",members:["forward: vec3<f32>","width: u32","right: vec3<f32>","height: u32","down: vec3<f32>","first_row: u32","samples: u32","view_count: u32","distance_count: u32","refine: u32","tolerance: f32","holes: u32","coding: u32","gain: f32","max_bounces: u32","rows: u32","pyramid_rows: u32","longest_segment: u32","first_segment: u32","proxy_count: u32","near_m: f32","far_m: f32","middle: vec2<f32>","log_step: f32","nearest_view: u32","refinements: u32","background: u32","spare: vec2<f32>"]},{name:"DrawnPicture",members:["right: vec3<f32>","scale_x: f32","down: vec3<f32>","shift_x: f32","forward: vec3<f32>","scale_y: f32","eye: vec3<f32>","shift_y: f32","eye_rest: vec3<f32>","nearest_m: f32","near_m: f32","far_m: f32","threshold: f32","spare: u32"]},{name:"View",members:["from_eye: vec3<f32>","near_m: f32","turn_x: vec3<f32>","camera_weight: f32","turn_y: vec3<f32>","greatest_inverse_depth: f32","turn_z: vec3<f32>","reach_m: f32","faces: array<u32, 8>"]},{name:"Face",members:["column: u32","row: u32","layer: u32","has_material: u32","width: u32","height: u32","pyramid_column: u32","pyramid_row: u32","levels: u32","number: u32","scale: vec2<f32>","centre: vec2<f32>","has_alpha: u32","spare: u32"]},{name:"SliceBlock",members:["width: u32","rows: u32","views: u32","spare: u32"]},{name:"SliceRun",members:["column: i32","disparity: i32","first: u32","flags: u32"]},{name:"SlicePlace",members:["place: i32","bias: u32"]},{name:"LineLight",members:["steady_rg: u32","steady_b: u32","own_rg: u32","own_b: u32"]},{name:"LineSplit",members:["light: vec3<f32>","place: f32"]},{name:"PixelRows",members:["width: u32","rows: u32","stride: u32","spare: u32"]}],kernels:[{name:"nodes",about:"Nodes of the quadtree: `DQPN`, `DQTR` and `DB4W`.",entry:"decode_nodes",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/product.wgsl","depth/domain.wgsl","depth/biquadratic.wgsl","depth/platelet.wgsl","depth/bc4w.wgsl","depth/runtime.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","log2_table: read-only-storage","pictures: storage"]},{name:"boxes-codes",about:"Boxes of depth codes: `DAAB`.",entry:"decode_codes",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","depth/records.wgsl","depth/boxes_of_values.wgsl","depth/texel_codes.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"boxes-material",about:"Boxes of material: `MAAB`.",entry:"decode_material",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","depth/records.wgsl","depth/boxes_of_values.wgsl","depth/texel_material.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"cells-8bit",about:"Cells of 8-bit colour: `CCL8`.",entry:"decode_cells",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/samples_8.wgsl","color/cells_of_samples.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"cells-half",about:"Cells of half floats: `CCLH`.",entry:"decode_cells",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/halves.wgsl","color/samples_half.wgsl","color/cells_of_samples.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"boxes-bc5",about:"Boxes of depth codes, block tiles in BC5: `DAB5`.",entry:"decode_codes",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","depth/records.wgsl","depth/block_tiles.wgsl","block/bc4.wgsl","block/bc5.wgsl","depth/block_tiles_bc5.wgsl","depth/texel_codes.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"boxes-bc1",about:"Boxes of material, block tiles in BC1: `MAB1`.",entry:"decode_material",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","depth/records.wgsl","depth/block_tiles.wgsl","block/bc1.wgsl","depth/block_tiles_bc1.wgsl","depth/texel_material.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"cells-bc1",about:"Cells of 8-bit colour with keyframes in BC1: `CCB1`.",entry:"decode_blocks",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","block/bc1.wgsl","color/samples_8.wgsl","color/keyframes_bc1.wgsl","color/cells_of_blocks.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"cells-bc7",about:"Cells of 8-bit colour with keyframes in BC7: `CCB7`.",entry:"decode_blocks",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","block/bptc.wgsl","block/bc7.wgsl","color/samples_8.wgsl","color/keyframes_bc7.wgsl","color/cells_of_blocks.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"cells-bc6h",about:"Cells of half floats with keyframes in BC6H: `CCB6`.",entry:"decode_blocks",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","block/bptc.wgsl","block/bc6h.wgsl","color/halves.wgsl","color/samples_half.wgsl","color/keyframes_bc6h.wgsl","color/cells_of_blocks.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"transform-read-8bit",about:"Reads the regions of `CTR8`, an invocation each.",entry:"read_regions",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/samples_8.wgsl","color/transform/domain_bytes.wgsl","color/transform/domain.wgsl","color/transform/chunk.wgsl","color/transform/contexts.wgsl","color/transform/coder.wgsl","color/transform/means.wgsl","color/transform/levels.wgsl","color/transform/palette.wgsl","color/transform/region.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","tables: read-only-storage","pictures: storage","scratch: storage"]},{name:"transform-8bit",about:"8-bit colour by a transform in space and time: `CTR8`.",entry:"show_regions",workgroup:64,reader:"transform-read-8bit",files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/samples_8.wgsl","color/transform/domain_bytes.wgsl","color/transform/domain.wgsl","color/transform/chunk.wgsl","color/transform/contexts.wgsl","color/transform/reconstruct.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","tables: read-only-storage","pictures: storage","scratch: storage"]},{name:"transform-read-half",about:"Reads the regions of `CTRH`, an invocation each.",entry:"read_regions",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/halves.wgsl","color/samples_half.wgsl","color/transform/domain_halves.wgsl","color/transform/domain.wgsl","color/transform/chunk.wgsl","color/transform/contexts.wgsl","color/transform/coder.wgsl","color/transform/means.wgsl","color/transform/levels.wgsl","color/transform/palette.wgsl","color/transform/region.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","tables: read-only-storage","pictures: storage","scratch: storage"]},{name:"transform-half",about:"Half floats by a transform in space and time: `CTRH`.",entry:"show_regions",workgroup:64,reader:"transform-read-half",files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/halves.wgsl","color/samples_half.wgsl","color/transform/domain_halves.wgsl","color/transform/domain.wgsl","color/transform/chunk.wgsl","color/transform/contexts.wgsl","color/transform/reconstruct.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","tables: read-only-storage","pictures: storage","scratch: storage"]},{name:"plan-records",about:"Finds the next record of each depth or material unit, and sizes the dispatch that applies them.",entry:"plan_records",workgroup:256,files:["shared/layout.wgsl","shared/sums.wgsl","shared/plan.wgsl","depth/record_table.wgsl"],bindings:["units: read-only-storage","chunks: read-only-storage","records: read-only-storage","items: read-only-storage","states: storage","jobs: storage","dispatch: storage"]},{name:"plan-cells",about:"Finds the two keyframes of each colour cell, and sizes the dispatch that blends them.",entry:"plan_cells",workgroup:256,files:["shared/layout.wgsl","shared/sums.wgsl","shared/plan.wgsl","shared/bytes.wgsl","color/cells.wgsl"],bindings:["chunks: read-only-storage","records: read-only-storage","items: read-only-storage","stream: read-only-storage","states: storage","jobs: storage","dispatch: storage"]},{name:"bc1",about:"All pixels of BC1 blocks.",entry:"decode_bc1",workgroup:64,files:["shared/layout.wgsl","block/bc1.wgsl","block/decode_bc1.wgsl"],bindings:["blocks: read-only-storage","texels: storage"]},{name:"bc4",about:"All pixels of BC4 blocks.",entry:"decode_bc4",workgroup:64,files:["shared/layout.wgsl","block/bc4.wgsl","block/decode_bc4.wgsl"],bindings:["blocks: read-only-storage","texels: storage"]},{name:"bc5",about:"All pixels of BC5 blocks.",entry:"decode_bc5",workgroup:64,files:["shared/layout.wgsl","block/bc4.wgsl","block/bc5.wgsl","block/decode_bc5.wgsl"],bindings:["blocks: read-only-storage","texels: storage"]},{name:"bc6h",about:"All pixels of BC6H blocks.",entry:"decode_bc6h",workgroup:64,files:["shared/layout.wgsl","block/bptc.wgsl","block/bc6h.wgsl","block/decode_bc6h.wgsl"],bindings:["blocks: read-only-storage","texels: storage"]},{name:"bc7",about:"All pixels of BC7 blocks.",entry:"decode_bc7",workgroup:64,files:["shared/layout.wgsl","block/bptc.wgsl","block/bc7.wgsl","block/decode_bc7.wgsl"],bindings:["blocks: read-only-storage","texels: storage"]},{name:"texels",about:"Inverse depths of texels from the depth codes of tiles.",entry:"write_depths",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","march/texels.wgsl"],bindings:["pictures: read-only-storage","tables: read-only-storage","jobs: read-only-storage","planes: storage"]},{name:"squares",about:"One level of the depth pyramids from the level below.",entry:"write_squares",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","march/pyramid.wgsl"],bindings:["jobs: read-only-storage","planes: storage"]},{name:"render",about:"Ray marching that tests every sample along a ray.",entry:"render",workgroup:64,files:["march/layout.wgsl","march/light_field.wgsl","march/marched_views.wgsl","march/active_views.wgsl","march/counters.wgsl","march/ray.wgsl","march/intersect.wgsl","march/interpolate.wgsl","march/shading.wgsl","march/diffuse.wgsl","march/layers.wgsl","march/render.wgsl"],bindings:["scene: read-only-storage","views: read-only-storage","faces: read-only-storage","distances_m: read-only-storage","inverse_depths: uint","colors: unfilterable-float","pixels: storage","counts: storage"]},{name:"render-pyramid",about:"Ray marching that skips segments which depth pyramids prove empty.",entry:"render",workgroup:64,files:["march/layout.wgsl","march/light_field.wgsl","march/marched_views.wgsl","march/active_views.wgsl","march/counters.wgsl","march/ray.wgsl","march/segments.wgsl","march/interpolate.wgsl","march/shading.wgsl","march/diffuse.wgsl","march/layers.wgsl","march/render.wgsl"],bindings:["scene: read-only-storage","views: read-only-storage","faces: read-only-storage","distances_m: read-only-storage","inverse_depths: uint","colors: unfilterable-float","pixels: storage","counts: storage","pyramids: uint"]},{name:"render-effects",about:"Ray marching with reflection and refraction.",entry:"render",workgroup:64,files:["march/layout.wgsl","march/light_field.wgsl","march/marched_views.wgsl","march/active_views.wgsl","march/counters.wgsl","march/ray.wgsl","march/segments.wgsl","march/interpolate.wgsl","march/shading.wgsl","march/material.wgsl","march/normal.wgsl","march/solid.wgsl","march/secondary_rays.wgsl","march/layers.wgsl","march/render.wgsl"],bindings:["scene: read-only-storage","views: read-only-storage","faces: read-only-storage","distances_m: read-only-storage","inverse_depths: uint","colors: unfilterable-float","pixels: storage","counts: storage","pyramids: uint","materials: unfilterable-float"]},{name:"slices",about:"The lines that pixels of output views show, in epipolar slices.",entry:"find_winners",workgroup:256,files:["shared/product.wgsl","epipolar/layout.wgsl","epipolar/lines.wgsl","epipolar/slice.wgsl"],bindings:["block: read-only-storage","starts: read-only-storage","run_starts: read-only-storage","runs: read-only-storage","depths: read-only-storage","places: read-only-storage","winners: storage","fragments: storage"]},{name:"line-light",about:"Light of the lines that pixels of output views show.",entry:"shade",workgroup:64,files:["color/blend.wgsl","color/halves.wgsl","epipolar/layout.wgsl","epipolar/beside.wgsl","epipolar/interpolate.wgsl"],bindings:["block: read-only-storage","starts: read-only-storage","lights: read-only-storage","winners: read-only-storage","pixels: storage","wanted: storage"]},{name:"line-highlights",about:"Highlights of the lines that pixels of output views show.",entry:"add_highlights",workgroup:64,files:["epipolar/layout.wgsl","epipolar/beside.wgsl","epipolar/highlights.wgsl"],bindings:["block: read-only-storage","starts: read-only-storage","winners: read-only-storage","split_starts: read-only-storage","splits: read-only-storage","eyes: read-only-storage","pixels: storage"]},{name:"active-counts",about:"Active pixels of each row of a layer of a source view.",entry:"count_active",workgroup:256,files:["epipolar/layout.wgsl","epipolar/active.wgsl"],bindings:["block: read-only-storage","shown: read-only-storage","counts: storage"]},{name:"compact",about:"Active pixels of a layer of a source view without gaps.",entry:"compact",workgroup:256,files:["epipolar/layout.wgsl","shared/sums.wgsl","epipolar/compact.wgsl"],bindings:["block: read-only-storage","shown: read-only-storage","counts: read-only-storage","active_pixels: storage"]},{name:"erosion-edges",about:"Edges up to each pixel of the scanlines of source views.",entry:"count_edges",workgroup:256,files:["epipolar/layout.wgsl","shared/sums.wgsl","epipolar/edges.wgsl"],bindings:["block: read-only-storage","moves: read-only-storage","edges: storage"]},{name:"erosion",about:"Pixels of source views from which an edge lies on the way to their place in another one.",entry:"count_eroded",workgroup:256,files:["epipolar/layout.wgsl","epipolar/erosion.wgsl"],bindings:["block: read-only-storage","moves: read-only-storage","edges: read-only-storage","eroded: storage"]}],drawings:[{name:"triangles",about:"The nearest triangle at each pixel, behind those of a former pass.",vertex:"place_corner",fragment:"name_triangle",files:["drawing/layout.wgsl","epipolar/triangles.wgsl"],bindings:["picture: read-only-storage","corners: read-only-storage","before: uint"],targets:["triangles: index"]},{name:"quads-painter",about:"Textured triangles blended in their order, and counted.",vertex:"place",fragment:"paint",files:["drawing/layout.wgsl","simplify/place.wgsl","simplify/texels.wgsl","simplify/painter.wgsl"],bindings:["picture: read-only-storage","corners: read-only-storage","light_of_codes: read-only-storage","atlas: uint"],targets:["light: over","counts: add"]},{name:"quads-z-buffer",about:"The nearest of textured triangles whose alpha covers the sample.",vertex:"place",fragment:"cover",files:["drawing/layout.wgsl","simplify/place.wgsl","simplify/texels.wgsl","simplify/z_buffer.wgsl"],bindings:["picture: read-only-storage","corners: read-only-storage","light_of_codes: read-only-storage","atlas: uint"],targets:["light: nearest"]},{name:"quads-overdraw",about:"Counts textured triangles over each sample.",vertex:"place",fragment:"count",files:["drawing/layout.wgsl","simplify/place.wgsl","simplify/overdraw.wgsl"],bindings:["picture: read-only-storage","corners: read-only-storage"],targets:["counts: add"]}]};var Ir=`// BC1 (blocks.md 3). Mirrors src/codec/block/bc1.rs.

// Expands a 5:6:5 colour to 8 bits per channel by replicating the high bits.
fn bc1_expand(color: u32) -> vec3u {
    let r = color >> 11u;
    let g = (color >> 5u) & 63u;
    let b = color & 31u;
    return vec3u((r << 3u) | (r >> 2u), (g << 2u) | (g >> 4u), (b << 3u) | (b >> 2u));
}

// Decodes one pixel: r | g << 8 | b << 16.
fn bc1_texel(words: vec2u, texel: u32) -> u32 {
    let first = words.x & 0xffffu;
    let second = words.x >> 16u;
    let a = bc1_expand(first);
    let b = bc1_expand(second);
    var color = a;
    switch ((words.y >> (2u * texel)) & 3u) {
        case 0u: {}
        case 1u: {
            color = b;
        }
        case 2u: {
            color = select((a + b + 1u) >> vec3u(1u), (2u * a + b + 1u) / 3u, first > second);
        }
        default: {
            color = select(vec3u(0u), (a + 2u * b + 1u) / 3u, first > second);
        }
    }
    return color.x | (color.y << 8u) | (color.z << 16u);
}

// Decodes all 16 pixels of a block.
fn bc1_texels(words: vec2u, out: ptr<function, array<u32, 16>>) {
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc1_texel(words, texel);
    }
}
`;var Br=`// BC4 (blocks.md 4). Mirrors src/codec/block/bc4.rs.

// Decodes the value of one pixel.
fn bc4_texel(words: vec2u, texel: u32) -> u32 {
    let at = 16u + 3u * texel;
    let shift = at & 31u;
    var i = words[at >> 5u] >> shift;
    if (shift > 29u) {
        i |= words.y << (32u - shift);
    }
    i &= 7u;
    let a = words.x & 255u;
    let b = (words.x >> 8u) & 255u;
    if (i == 0u) {
        return a;
    }
    if (i == 1u) {
        return b;
    }
    if (a > b) {
        return ((8u - i) * a + (i - 1u) * b + 3u) / 7u;
    }
    if (i == 6u) {
        return 0u;
    }
    if (i == 7u) {
        return 255u;
    }
    return ((6u - i) * a + (i - 1u) * b + 2u) / 5u;
}

// Decodes all 16 values of a block.
fn bc4_texels(words: vec2u, out: ptr<function, array<u32, 16>>) {
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc4_texel(words, texel);
    }
}
`;var Dr=`// BC5 (blocks.md 5). Mirrors src/codec/block/bc5.rs. Needs \`bc4_texel\`.

// Decodes one pixel: r | g << 8.
fn bc5_texel(words: vec4u, texel: u32) -> u32 {
    return bc4_texel(words.xy, texel) | (bc4_texel(words.zw, texel) << 8u);
}

// Decodes all 16 pixels of a block.
fn bc5_texels(words: vec4u, out: ptr<function, array<u32, 16>>) {
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc5_texel(words, texel);
    }
}
`;var Hr=`// BC6H UF16 (blocks.md 7). Mirrors src/codec/block/bc6h.rs. Needs bptc.wgsl.

// Fields of a block before the indices.
struct Bc6hValues {
    // 0 if the mode is reserved.
    subsets: u32,
    endpoint_bits: u32,
    // Bits of the endpoint deltas of red, green and blue; 0 if the endpoints are not delta-coded.
    delta: vec3u,
    partition_number: u32,
    w: vec3u,
    x: vec3u,
    y: vec3u,
    z: vec3u,
}

// Reverses the order of \`count\` bits.
fn bc6h_reversed(bits: u32, count: u32) -> u32 {
    return reverseBits(bits) >> (32u - count);
}

// Reads the fields of a block. The comment in each case is the bit layout of that mode, from the first bit after the mode.
fn bc6h_values(words: vec4u) -> Bc6hValues {
    var code = words.x & 3u;
    if (code > 1u) {
        code = words.x & 31u;
    }
    var block: Bc6hValues;
    block.subsets = 1u;
    switch (code) {
        case 0u: {
            // gy4 by4 bz4 rw0-9 gw0-9 bw0-9 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
            block.endpoint_bits = 10u;
            block.delta = vec3u(5u, 5u, 5u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u),
                bptc_bits(words, 15u, 10u),
                bptc_bits(words, 25u, 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 5u),
                bptc_bits(words, 45u, 5u),
                bptc_bits(words, 55u, 5u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 5u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 2u, 1u) << 4u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 3u, 1u) << 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 5u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 40u, 1u) << 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u)
                    | (bptc_bits(words, 4u, 1u) << 4u),
            );
        }
        case 1u: {
            // gy5 gz4-5 rw0-6 bz0-1 by4 gw0-6 by5 bz2 gy4 bw0-6 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5 d0-4
            block.endpoint_bits = 7u;
            block.delta = vec3u(6u, 6u, 6u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 7u),
                bptc_bits(words, 15u, 7u),
                bptc_bits(words, 25u, 7u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 6u),
                bptc_bits(words, 45u, 6u),
                bptc_bits(words, 55u, 6u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 6u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u) | (bptc_bits(words, 2u, 1u) << 5u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u) | (bptc_bits(words, 22u, 1u) << 5u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 6u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 3u, 2u) << 4u),
                bptc_bits(words, 12u, 2u)
                    | (bptc_bits(words, 23u, 1u) << 2u)
                    | (bptc_bits(words, 32u, 1u) << 3u)
                    | (bptc_bits(words, 34u, 1u) << 4u)
                    | (bptc_bits(words, 33u, 1u) << 5u),
            );
        }
        case 2u: {
            // rw0-9 gw0-9 bw0-9 rx0-4 rw10 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
            block.endpoint_bits = 11u;
            block.delta = vec3u(5u, 4u, 4u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bptc_bits(words, 40u, 1u) << 10u),
                bptc_bits(words, 15u, 10u) | (bptc_bits(words, 49u, 1u) << 10u),
                bptc_bits(words, 25u, 10u) | (bptc_bits(words, 59u, 1u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 5u),
                bptc_bits(words, 45u, 4u),
                bptc_bits(words, 55u, 4u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 5u),
                bptc_bits(words, 41u, 4u),
                bptc_bits(words, 61u, 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 5u),
                bptc_bits(words, 51u, 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u),
            );
        }
        case 6u: {
            // rw0-9 gw0-9 bw0-9 rx0-3 rw10 gz4 gy0-3 gx0-4 gw10 gz0-3 bx0-3 bw10 bz1 by0-3 ry0-3 bz0 bz2 rz0-3 gy4 bz3 d0-4
            block.endpoint_bits = 11u;
            block.delta = vec3u(4u, 5u, 4u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bptc_bits(words, 39u, 1u) << 10u),
                bptc_bits(words, 15u, 10u) | (bptc_bits(words, 50u, 1u) << 10u),
                bptc_bits(words, 25u, 10u) | (bptc_bits(words, 59u, 1u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 4u),
                bptc_bits(words, 45u, 5u),
                bptc_bits(words, 55u, 4u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 4u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 75u, 1u) << 4u),
                bptc_bits(words, 61u, 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 4u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 40u, 1u) << 4u),
                bptc_bits(words, 69u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u),
            );
        }
        case 10u: {
            // rw0-9 gw0-9 bw0-9 rx0-3 rw10 by4 gy0-3 gx0-3 gw10 bz0 gz0-3 bx0-4 bw10 by0-3 ry0-3 bz1-2 rz0-3 bz4 bz3 d0-4
            block.endpoint_bits = 11u;
            block.delta = vec3u(4u, 4u, 5u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bptc_bits(words, 39u, 1u) << 10u),
                bptc_bits(words, 15u, 10u) | (bptc_bits(words, 49u, 1u) << 10u),
                bptc_bits(words, 25u, 10u) | (bptc_bits(words, 60u, 1u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 4u),
                bptc_bits(words, 45u, 4u),
                bptc_bits(words, 55u, 5u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 4u),
                bptc_bits(words, 41u, 4u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 40u, 1u) << 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 4u),
                bptc_bits(words, 51u, 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 69u, 2u) << 1u)
                    | (bptc_bits(words, 76u, 1u) << 3u)
                    | (bptc_bits(words, 75u, 1u) << 4u),
            );
        }
        case 14u: {
            // rw0-8 by4 gw0-8 gy4 bw0-8 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
            block.endpoint_bits = 9u;
            block.delta = vec3u(5u, 5u, 5u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 9u),
                bptc_bits(words, 15u, 9u),
                bptc_bits(words, 25u, 9u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 5u),
                bptc_bits(words, 45u, 5u),
                bptc_bits(words, 55u, 5u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 5u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 5u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 40u, 1u) << 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u)
                    | (bptc_bits(words, 34u, 1u) << 4u),
            );
        }
        case 18u: {
            // rw0-7 gz4 by4 gw0-7 bz2 gy4 bw0-7 bz3-4 rx0-5 gy0-3 gx0-4 bz0 gz0-3 bx0-4 bz1 by0-3 ry0-5 rz0-5 d0-4
            block.endpoint_bits = 8u;
            block.delta = vec3u(6u, 5u, 5u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 8u),
                bptc_bits(words, 15u, 8u),
                bptc_bits(words, 25u, 8u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 6u),
                bptc_bits(words, 45u, 5u),
                bptc_bits(words, 55u, 5u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 6u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 6u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 13u, 1u) << 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 23u, 1u) << 2u)
                    | (bptc_bits(words, 33u, 2u) << 3u),
            );
        }
        case 22u: {
            // rw0-7 bz0 by4 gw0-7 gy5 gy4 bw0-7 gz5 bz4 rx0-4 gz4 gy0-3 gx0-5 gz0-3 bx0-4 bz1 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
            block.endpoint_bits = 8u;
            block.delta = vec3u(5u, 6u, 5u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 8u),
                bptc_bits(words, 15u, 8u),
                bptc_bits(words, 25u, 8u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 5u),
                bptc_bits(words, 45u, 6u),
                bptc_bits(words, 55u, 5u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 5u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u) | (bptc_bits(words, 23u, 1u) << 5u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 5u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 40u, 1u) << 4u) | (bptc_bits(words, 33u, 1u) << 5u),
                bptc_bits(words, 13u, 1u)
                    | (bptc_bits(words, 60u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u)
                    | (bptc_bits(words, 34u, 1u) << 4u),
            );
        }
        case 26u: {
            // rw0-7 bz1 by4 gw0-7 by5 gy4 bw0-7 bz5 bz4 rx0-4 gz4 gy0-3 gx0-4 bz0 gz0-3 bx0-5 by0-3 ry0-4 bz2 rz0-4 bz3 d0-4
            block.endpoint_bits = 8u;
            block.delta = vec3u(5u, 5u, 6u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 8u),
                bptc_bits(words, 15u, 8u),
                bptc_bits(words, 25u, 8u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 5u),
                bptc_bits(words, 45u, 5u),
                bptc_bits(words, 55u, 6u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 5u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u) | (bptc_bits(words, 23u, 1u) << 5u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 5u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 40u, 1u) << 4u),
                bptc_bits(words, 50u, 1u)
                    | (bptc_bits(words, 13u, 1u) << 1u)
                    | (bptc_bits(words, 70u, 1u) << 2u)
                    | (bptc_bits(words, 76u, 1u) << 3u)
                    | (bptc_bits(words, 34u, 1u) << 4u)
                    | (bptc_bits(words, 33u, 1u) << 5u),
            );
        }
        case 30u: {
            // rw0-5 gz4 bz0-1 by4 gw0-5 gy5 by5 bz2 gy4 bw0-5 gz5 bz3 bz5 bz4 rx0-5 gy0-3 gx0-5 gz0-3 bx0-5 by0-3 ry0-5 rz0-5 d0-4
            block.endpoint_bits = 6u;
            block.delta = vec3u(0u);
            block.subsets = 2u;
            block.partition_number = bptc_bits(words, 77u, 5u);
            block.w = vec3u(
                bptc_bits(words, 5u, 6u),
                bptc_bits(words, 15u, 6u),
                bptc_bits(words, 25u, 6u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 6u),
                bptc_bits(words, 45u, 6u),
                bptc_bits(words, 55u, 6u),
            );
            block.y = vec3u(
                bptc_bits(words, 65u, 6u),
                bptc_bits(words, 41u, 4u) | (bptc_bits(words, 24u, 1u) << 4u) | (bptc_bits(words, 21u, 1u) << 5u),
                bptc_bits(words, 61u, 4u) | (bptc_bits(words, 14u, 1u) << 4u) | (bptc_bits(words, 22u, 1u) << 5u),
            );
            block.z = vec3u(
                bptc_bits(words, 71u, 6u),
                bptc_bits(words, 51u, 4u) | (bptc_bits(words, 11u, 1u) << 4u) | (bptc_bits(words, 31u, 1u) << 5u),
                bptc_bits(words, 12u, 2u)
                    | (bptc_bits(words, 23u, 1u) << 2u)
                    | (bptc_bits(words, 32u, 1u) << 3u)
                    | (bptc_bits(words, 34u, 1u) << 4u)
                    | (bptc_bits(words, 33u, 1u) << 5u),
            );
        }
        case 3u: {
            // rw0-9 gw0-9 bw0-9 rx0-9 gx0-9 bx0-9
            block.endpoint_bits = 10u;
            block.delta = vec3u(0u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u),
                bptc_bits(words, 15u, 10u),
                bptc_bits(words, 25u, 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 10u),
                bptc_bits(words, 45u, 10u),
                bptc_bits(words, 55u, 10u),
            );
        }
        case 7u: {
            // rw0-9 gw0-9 bw0-9 rx0-8 rw10 gx0-8 gw10 bx0-8 bw10
            block.endpoint_bits = 11u;
            block.delta = vec3u(9u, 9u, 9u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bptc_bits(words, 44u, 1u) << 10u),
                bptc_bits(words, 15u, 10u) | (bptc_bits(words, 54u, 1u) << 10u),
                bptc_bits(words, 25u, 10u) | (bptc_bits(words, 64u, 1u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 9u),
                bptc_bits(words, 45u, 9u),
                bptc_bits(words, 55u, 9u),
            );
        }
        case 11u: {
            // rw0-9 gw0-9 bw0-9 rx0-7 rw11-10 gx0-7 gw11-10 bx0-7 bw11-10
            block.endpoint_bits = 12u;
            block.delta = vec3u(8u, 8u, 8u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bc6h_reversed(bptc_bits(words, 43u, 2u), 2u) << 10u),
                bptc_bits(words, 15u, 10u) | (bc6h_reversed(bptc_bits(words, 53u, 2u), 2u) << 10u),
                bptc_bits(words, 25u, 10u) | (bc6h_reversed(bptc_bits(words, 63u, 2u), 2u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 8u),
                bptc_bits(words, 45u, 8u),
                bptc_bits(words, 55u, 8u),
            );
        }
        case 15u: {
            // rw0-9 gw0-9 bw0-9 rx0-3 rw15-10 gx0-3 gw15-10 bx0-3 bw15-10
            block.endpoint_bits = 16u;
            block.delta = vec3u(4u, 4u, 4u);
            block.w = vec3u(
                bptc_bits(words, 5u, 10u) | (bc6h_reversed(bptc_bits(words, 39u, 6u), 6u) << 10u),
                bptc_bits(words, 15u, 10u) | (bc6h_reversed(bptc_bits(words, 49u, 6u), 6u) << 10u),
                bptc_bits(words, 25u, 10u) | (bc6h_reversed(bptc_bits(words, 59u, 6u), 6u) << 10u),
            );
            block.x = vec3u(
                bptc_bits(words, 35u, 4u),
                bptc_bits(words, 45u, 4u),
                bptc_bits(words, 55u, 4u),
            );
        }
        default: {
            block.subsets = 0u;
        }
    }
    return block;
}

// Unquantises an endpoint to 16 bits. In delta-coded modes \`value\` is a signed difference from endpoint \`w\`.
fn bc6h_endpoint(block: Bc6hValues, value: vec3u) -> vec3u {
    var whole = value;
    if (block.delta.x > 0u) {
        let unused = 32u - block.delta;
        let difference = vec3i(value << unused) >> unused;
        whole = (block.w + vec3u(difference)) & vec3u((1u << block.endpoint_bits) - 1u);
    }
    return bc6h_widen(whole, block.endpoint_bits);
}

// Unquantises values of \`endpoint_bits\` bits to 16 bits.
fn bc6h_widen(value: vec3u, endpoint_bits: u32) -> vec3u {
    if (endpoint_bits >= 15u) {
        return value;
    }
    let spread = ((value << vec3u(16u)) + 0x8000u) >> vec3u(endpoint_bits);
    let last = vec3u((1u << endpoint_bits) - 1u);
    return select(select(spread, vec3u(0xffffu), value == last), vec3u(0u), value == vec3u(0u));
}

// A block with unquantised endpoints: a and b of subset 0, c and d of subset 1.
struct Bc6h {
    words: vec4u,
    subsets: u32,
    parts: BptcPartition,
    a: vec3u,
    b: vec3u,
    c: vec3u,
    d: vec3u,
}

fn bc6h_open(words: vec4u) -> Bc6h {
    let values = bc6h_values(words);
    return Bc6h(
        words,
        values.subsets,
        bptc_partition(values.subsets, values.partition_number),
        bc6h_widen(values.w, values.endpoint_bits),
        bc6h_endpoint(values, values.x),
        bc6h_endpoint(values, values.y),
        bc6h_endpoint(values, values.z),
    );
}

// Decodes one pixel: r | g << 16 in the first word, b in the second.
fn bc6h_pixel(block: Bc6h, texel: u32) -> vec2u {
    if (block.subsets == 0u) {
        return vec2u(0u);
    }
    let second = bptc_subset(block.parts, texel) == 1u;
    let a = select(block.a, block.c, second);
    let b = select(block.b, block.d, second);
    let index_bits = 5u - block.subsets;
    let indices_at = select(65u, 82u, block.subsets == 2u);
    let index = bptc_index(block.words, indices_at, index_bits, block.parts, texel);
    // Scales 0 to 65535 to the bit patterns of finite half floats.
    let halves = (bptc_mix(a, b, index, index_bits) * 31u) >> vec3u(6u);
    return vec2u(halves.x | (halves.y << 16u), halves.z);
}

// Decodes all 16 pixels of a block.
fn bc6h_texels(words: vec4u, out: ptr<function, array<vec2u, 16>>) {
    let block = bc6h_open(words);
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc6h_pixel(block, texel);
    }
}
`;var Gr=`// BC7 (blocks.md 8). Mirrors src/codec/block/bc7.rs. Needs bptc.wgsl.

// Bit allocation of a mode.
struct Bc7Mode {
    subsets: u32,
    partition_bits: u32,
    rotation_bits: u32,
    selection_bits: u32,
    color_bits: u32,
    alpha_bits: u32,
    // P-bits: 0 none, 1 one per endpoint, 2 one per subset.
    low_bits: u32,
    index_bits: u32,
    second_index_bits: u32,
}

// Returns a row of the mode table in blocks.md 8; subsets is 0 if the mode is reserved.
fn bc7_mode(number: u32) -> Bc7Mode {
    switch (number) {
        case 0u: {
            return Bc7Mode(3u, 4u, 0u, 0u, 4u, 0u, 1u, 3u, 0u);
        }
        case 1u: {
            return Bc7Mode(2u, 6u, 0u, 0u, 6u, 0u, 2u, 3u, 0u);
        }
        case 2u: {
            return Bc7Mode(3u, 6u, 0u, 0u, 5u, 0u, 0u, 2u, 0u);
        }
        case 3u: {
            return Bc7Mode(2u, 6u, 0u, 0u, 7u, 0u, 1u, 2u, 0u);
        }
        case 4u: {
            return Bc7Mode(1u, 0u, 2u, 1u, 5u, 6u, 0u, 2u, 3u);
        }
        case 5u: {
            return Bc7Mode(1u, 0u, 2u, 0u, 7u, 8u, 0u, 2u, 2u);
        }
        case 6u: {
            return Bc7Mode(1u, 0u, 0u, 0u, 7u, 7u, 1u, 4u, 0u);
        }
        case 7u: {
            return Bc7Mode(2u, 6u, 0u, 0u, 5u, 5u, 1u, 2u, 0u);
        }
        default: {
            return Bc7Mode();
        }
    }
}

// Fields of a block before the endpoints, and the bit offsets of the endpoints and indices.
struct Bc7 {
    words: vec4u,
    mode: Bc7Mode,
    parts: BptcPartition,
    rotation: u32,
    selection: u32,
    endpoints_at: u32,
    indices_at: u32,
    second_indices_at: u32,
}

fn bc7_open(words: vec4u) -> Bc7 {
    let number = countTrailingZeros(words.x);
    let mode = bc7_mode(number);
    let rotation_at = number + 1u + mode.partition_bits;
    let selection_at = rotation_at + mode.rotation_bits;
    let endpoints_at = selection_at + mode.selection_bits;
    var indices_at = endpoints_at + 2u * mode.subsets * (3u * mode.color_bits + mode.alpha_bits);
    if (mode.low_bits > 0u) {
        indices_at += 2u * mode.subsets / mode.low_bits;
    }
    return Bc7(
        words,
        mode,
        bptc_partition(mode.subsets, bptc_bits(words, number + 1u, mode.partition_bits)),
        bptc_bits(words, rotation_at, mode.rotation_bits),
        bptc_bits(words, selection_at, mode.selection_bits),
        endpoints_at,
        indices_at,
        indices_at + 16u * mode.index_bits - mode.subsets,
    );
}

// Decodes endpoint \`number\` to 8 bits per channel.
fn bc7_endpoint(block: Bc7, number: u32) -> vec4u {
    let words = block.words;
    let mode = block.mode;
    let at = block.endpoints_at;
    let step = 2u * mode.subsets * mode.color_bits;
    let color_at = at + number * mode.color_bits;
    var value = vec4u(
        bptc_bits(words, color_at, mode.color_bits),
        bptc_bits(words, color_at + step, mode.color_bits),
        bptc_bits(words, color_at + 2u * step, mode.color_bits),
        bptc_bits(words, at + 3u * step + number * mode.alpha_bits, mode.alpha_bits),
    );
    var count = vec4u(vec3u(mode.color_bits), mode.alpha_bits);
    if (mode.low_bits > 0u) {
        let low_at = at + 3u * step + 2u * mode.subsets * mode.alpha_bits;
        value = (value << vec4u(1u)) | vec4u(bptc_bits(words, low_at + number / mode.low_bits, 1u));
        count += 1u;
    }
    if (mode.alpha_bits == 0u) {
        value.w = 255u;
        count.w = 8u;
    }
    return (value << (8u - count)) | (value >> (2u * count - 8u));
}

// Decodes one pixel: r | g << 8 | b << 16 | a << 24.
fn bc7_pixel(block: Bc7, texel: u32) -> u32 {
    let mode = block.mode;
    if (mode.subsets == 0u) {
        return 0u;
    }
    let pair = 2u * bptc_subset(block.parts, texel);
    let a = bc7_endpoint(block, pair);
    let b = bc7_endpoint(block, pair + 1u);
    // An index and its number of bits.
    let first = vec2u(bptc_index(block.words, block.indices_at, mode.index_bits, block.parts, texel), mode.index_bits);
    var of_color = first;
    var of_alpha = first;
    if (mode.second_index_bits > 0u) {
        let count = mode.second_index_bits;
        let second = vec2u(bptc_index(block.words, block.second_indices_at, count, block.parts, texel), count);
        if (block.selection == 1u) {
            of_color = second;
        } else {
            of_alpha = second;
        }
    }
    let color = bptc_mix(a.xyz, b.xyz, of_color.x, of_color.y);
    let alpha = bptc_mix(a.www, b.www, of_alpha.x, of_alpha.y).x;
    var pixel = vec4u(color, alpha);
    switch (block.rotation) {
        case 1u: {
            pixel = pixel.wyzx;
        }
        case 2u: {
            pixel = pixel.xwzy;
        }
        case 3u: {
            pixel = pixel.xywz;
        }
        default: {}
    }
    return pixel.x | (pixel.y << 8u) | (pixel.z << 16u) | (pixel.w << 24u);
}

// Decodes all 16 pixels of a block.
fn bc7_texels(words: vec4u, out: ptr<function, array<u32, 16>>) {
    let block = bc7_open(words);
    for (var texel = 0u; texel < 16u; texel++) {
        (*out)[texel] = bc7_pixel(block, texel);
    }
}
`;var zr=`// Functions and tables shared by BC6H and BC7 (blocks.md 6). Mirrors src/codec/block/bptc.rs.

// Partitions into two subsets: bit t is the subset of pixel t; bits 16 to 19 are the anchor of subset 1.
const BPTC_TWO = array<u32, 64>(
    0xfccccu, 0xf8888u, 0xfeeeeu, 0xfecc8u, 0xfc880u, 0xffeecu, 0xffec8u, 0xfec80u,
    0xfc800u, 0xfffecu, 0xffe80u, 0xfe800u, 0xfffe8u, 0xfff00u, 0xffff0u, 0xff000u,
    0xff710u, 0x2008eu, 0x87100u, 0x208ceu, 0x2008cu, 0x87310u, 0x83100u, 0xf8cceu,
    0x2088cu, 0x83110u, 0x26666u, 0x2366cu, 0x817e8u, 0x80ff0u, 0x2718eu, 0x2399cu,
    0xfaaaau, 0xff0f0u, 0x65a5au, 0x833ccu, 0x23c3cu, 0x855aau, 0xf9696u, 0xfa55au,
    0x273ceu, 0x813c8u, 0x2324cu, 0x23bdcu, 0x26996u, 0xfc33cu, 0xf9966u, 0x60660u,
    0x60272u, 0x204e4u, 0x64e40u, 0x82720u, 0xfc936u, 0xf936cu, 0x239c6u, 0x2639cu,
    0xf9336u, 0xf9cc6u, 0xf817eu, 0xfe718u, 0xfccf0u, 0x20fccu, 0x27744u, 0xfee22u,
);

// Partitions into three subsets: bits 2t and 2t + 1 are the subset of pixel t.
const BPTC_THREE = array<u32, 64>(
    0xaa685050u, 0x6a5a5040u, 0x5a5a4200u, 0x5450a0a8u, 0xa5a50000u, 0xa0a05050u, 0x5555a0a0u, 0x5a5a5050u,
    0xaa550000u, 0xaa555500u, 0xaaaa5500u, 0x90909090u, 0x94949494u, 0xa4a4a4a4u, 0xa9a59450u, 0x2a0a4250u,
    0xa5945040u, 0x0a425054u, 0xa5a5a500u, 0x55a0a0a0u, 0xa8a85454u, 0x6a6a4040u, 0xa4a45000u, 0x1a1a0500u,
    0x0050a4a4u, 0xaaa59090u, 0x14696914u, 0x69691400u, 0xa08585a0u, 0xaa821414u, 0x50a4a450u, 0x6a5a0200u,
    0xa9a58000u, 0x5090a0a8u, 0xa8a09050u, 0x24242424u, 0x00aa5500u, 0x24924924u, 0x24499224u, 0x50a50a50u,
    0x500aa550u, 0xaaaa4444u, 0x66660000u, 0xa5a0a5a0u, 0x50a050a0u, 0x69286928u, 0x44aaaa44u, 0x66666600u,
    0xaa444444u, 0x54a854a8u, 0x95809580u, 0x96969600u, 0xa85454a8u, 0x80959580u, 0xaa141414u, 0x96960000u,
    0xaaaa1414u, 0xa05050a0u, 0xa0a5a5a0u, 0x96000000u, 0x40804080u, 0xa9a8a9a8u, 0xaaaaaa44u, 0x2a4a5254u,
);

// Anchors of subsets 1 and 2 of the partitions into three subsets: four bits each, four partitions per word.
const BPTC_ANCHORS_OF_THREE = array<u32, 16>(
    0x3f8f83f3u, 0x8f3ff3f8u, 0xf6f6f8f8u, 0x83f3f5f6u, 0x3ff883f3u, 0x8af683f3u, 0xa668f835u, 0x8faff5f8u,
    0xa5f33ff8u, 0xaf988aa6u, 0xf58ff36fu, 0x8f6f6f3fu, 0xf5f53ff3u, 0xfaf5f8f5u, 0xfdf8faf5u, 0x83f3fc3fu,
);

// Returns \`count\` bits of a block, at most 32, starting at bit \`at\`.
fn bptc_bits(words: vec4u, at: u32, count: u32) -> u32 {
    let shift = at & 31u;
    var bits = words[at >> 5u] >> shift;
    if (shift + count > 32u) {
        bits |= words[(at >> 5u) + 1u] << (32u - shift);
    }
    return bits & ((1u << count) - 1u);
}

struct BptcPartition {
    // Bits 2t and 2t + 1: the subset of pixel t.
    map: u32,
    // Bit t: pixel t is the anchor of its subset.
    anchors: u32,
}

// Returns partition \`number\` into \`subsets\` (1, 2 or 3) subsets.
fn bptc_partition(subsets: u32, number: u32) -> BptcPartition {
    if (subsets == 2u) {
        let row = BPTC_TWO[number];
        var map = row & 0xffffu;
        map = (map | (map << 8u)) & 0x00ff00ffu;
        map = (map | (map << 4u)) & 0x0f0f0f0fu;
        map = (map | (map << 2u)) & 0x33333333u;
        map = (map | (map << 1u)) & 0x55555555u;
        return BptcPartition(map, 1u | (1u << (row >> 16u)));
    }
    if (subsets == 3u) {
        let anchors = BPTC_ANCHORS_OF_THREE[number >> 2u] >> ((number & 3u) * 8u);
        return BptcPartition(BPTC_THREE[number], 1u | (1u << (anchors & 15u)) | (1u << ((anchors >> 4u) & 15u)));
    }
    return BptcPartition(0u, 1u);
}

fn bptc_subset(parts: BptcPartition, texel: u32) -> u32 {
    return (parts.map >> (2u * texel)) & 3u;
}

// Returns the index of a pixel. The indices start at bit \`at\` and have \`count\` bits each, those of anchor pixels one bit less.
fn bptc_index(words: vec4u, at: u32, count: u32, parts: BptcPartition, texel: u32) -> u32 {
    let anchors_before = countOneBits(parts.anchors & ((1u << texel) - 1u));
    return bptc_bits(words, at + texel * count - anchors_before, count - ((parts.anchors >> texel) & 1u));
}

// Returns the weight of an index of 2, 3 or 4 bits, in 64ths. The formula yields the rows of the table in blocks.md 6.
fn bptc_weight(index: u32, count: u32) -> u32 {
    let last = (1u << count) - 1u;
    return (64u * index + last / 2u) / last;
}

// Interpolates between two endpoints by an index of \`count\` bits.
fn bptc_mix(a: vec3u, b: vec3u, index: u32, count: u32) -> vec3u {
    let weight = bptc_weight(index, count);
    return (a * (64u - weight) + b * weight + 32u) >> vec3u(6u);
}
`;var $r=`// Interpolation between two keyframes (arithmetic.md 3, 4). Mirrors src/codec/color/blend.rs.

fn lerp(a: vec3u, b: vec3u, weight: u32) -> vec3u {
    return (a * (255u - weight) + b * weight + 127u) / 255u;
}

// Maps bit patterns of half floats to integer keys that increase with the value.
fn keys_of(bits: vec3u) -> vec3u {
    return bits ^ select(vec3u(0x8000u), vec3u(0xffffu), bits >= vec3u(0x8000u));
}

fn bits_of(keys: vec3u) -> vec3u {
    return keys ^ select(vec3u(0xffffu), vec3u(0x8000u), keys >= vec3u(0x8000u));
}
`;var Vr=`// Plans colour cells: the two keyframes that each listed cell blends, and their weight (color.md 4). Mirrors
// src/codec/color/cells.rs.

@group(0) @binding(0) var<storage, read> chunks: array<Chunk>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> items: Items;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read_write> states: array<State>;
@group(0) @binding(5) var<storage, read_write> jobs: Jobs;
@group(0) @binding(6) var<storage, read_write> dispatch: Dispatch;

// Returns the index in the chunk of the last keyframe at or before a frame.
fn keyframe_of(chunk: Chunk, frame: u32) -> u32 {
    var low = 0u;
    var high = chunk.record_count;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (records[chunk.first_record + middle].frame <= frame) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low - 1u;
}

// Returns the job that blends an item's frame; an empty job if the cell already shows that frame.
fn blend_of(item: Item) -> Job {
    let chunk = chunks[item.chunk];
    let keyframe = keyframe_of(chunk, item.frame);
    var weight = 0u;
    if (item.frame < chunk.weight_count) {
        weight = byte_at(chunk.weights_at + item.frame);
    }
    let wanted = State(item.key, keyframe, weight);
    let shown = states[item.unit];
    if (shown.key == wanted.key && shown.frame == wanted.frame && shown.weight == wanted.weight) {
        return Job(item.unit, 0u, NONE, NONE, 0u);
    }
    states[item.unit] = wanted;
    let first = chunk.first_record + keyframe;
    var next = first;
    if (weight > 0u) {
        next = first + 1u;
        if (keyframe + 1u == chunk.record_count) {
            next = chunks[item.next].first_record;
        }
    }
    return Job(item.unit, 0u, first, next, weight);
}

@compute @workgroup_size(SUM_WORKGROUP)
fn plan_cells(@builtin(local_invocation_index) local: u32) {
    var before = 0u;
    for (var first = 0u; first < items.count; first += SUM_WORKGROUP) {
        let at = first + local;
        var job: Job;
        var work = 0u;
        if (at < items.count) {
            job = blend_of(items.list[at]);
            if (job.record != NONE) {
                work = records[job.record].work;
            }
        }
        job.end = before + running_sum(local, work);
        if (at < items.count) {
            jobs.list[at] = job;
        }
        before += sums[SUM_WORKGROUP - 1u];
    }
    if (local == 0u) {
        finish_plan(before);
    }
}
`;var Wr=`// Decodes cells whose keyframes may be block-compressed (color.md 4): \`CellState\` of src/codec/decode/decoder.rs. An invocation
// writes the 4x4 pixels of a block. Needs \`keyframe_block\`, \`empty_block\`, \`unpack\`, \`sample_pixel\`, \`between\` and \`put_pixel\`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read_write> pictures: array<u32>;

fn in_blocks(keyframe: Record) -> bool {
    return keyframe.coding == KEYFRAME_BLOCKS;
}

@compute @workgroup_size(WORKGROUP)
fn decode_blocks(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let unit = units[job.unit];
    let block = invocation - job_begin(number);
    let first = records[job.record];
    let second = records[job.next];
    var first_block = empty_block();
    var second_block = empty_block();
    if (in_blocks(first)) {
        keyframe_block(first, block, &first_block);
    }
    if (job.weight > 0u && in_blocks(second)) {
        keyframe_block(second, block, &second_block);
    }
    let columns = (unit.width + 3u) / 4u;
    let corner = 4u * vec2u(block % columns, block / columns);
    for (var texel = 0u; texel < 16u; texel++) {
        let x = corner.x + texel % 4u;
        let y = corner.y + texel / 4u;
        if (x >= unit.width || y >= unit.height) {
            continue;
        }
        let pixel = y * unit.width + x;
        var color = unpack(first_block[texel]);
        if (!in_blocks(first)) {
            color = sample_pixel(first, pixel);
        }
        if (job.weight > 0u) {
            var next = unpack(second_block[texel]);
            if (!in_blocks(second)) {
                next = sample_pixel(second, pixel);
            }
            color = between(color, next, job.weight);
        }
        put_pixel(unit, pixel, color);
    }
}
`;var jr=`// Decodes cells whose keyframes are raw samples (color.md 4): \`CellState\` of src/codec/decode/decoder.rs. An invocation writes a
// pixel. Needs \`sample_pixel\`, \`between\` and \`put_pixel\`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read_write> pictures: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn decode_cells(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let pixel = invocation - job_begin(number);
    var color = sample_pixel(records[job.record], pixel);
    if (job.weight > 0u) {
        color = between(color, sample_pixel(records[job.next], pixel), job.weight);
    }
    put_pixel(units[job.unit], pixel, color);
}
`;var qr=`// Packing and interpolation of half-float pixels: \`impl Sample for HalfKey\` of src/codec/color/blend.rs. Needs \`lerp\`.

// Unpacks a pixel from the layout of \`pictures\`: r | g << 16 in the first word, b in the second.
fn unpack(pixel: vec2u) -> vec3u {
    return vec3u(pixel.x & 0xffffu, pixel.x >> 16u, pixel.y & 0xffffu);
}

fn pack(color: vec3u) -> vec2u {
    return vec2u(color.x | (color.y << 16u), color.z);
}

fn between(a: vec3u, b: vec3u, weight: u32) -> vec3u {
    return bits_of(lerp(keys_of(a), keys_of(b), weight));
}
`;var Kr=`// Keyframes in BC1 blocks (color.md 4). Mirrors src/codec/color/keyframe_blocks.rs. Needs \`word_at\` and \`bc1_texels\`.

fn keyframe_block(keyframe: Record, block: u32, out: ptr<function, array<u32, 16>>) {
    let at = keyframe.at + 8u * block;
    bc1_texels(vec2u(word_at(at), word_at(at + 4u)), out);
}
`;var Xr=`// Keyframes in BC6H blocks (color.md 4). Mirrors src/codec/color/keyframe_blocks.rs. Needs \`word_at\` and \`bc6h_texels\`.

fn keyframe_block(keyframe: Record, block: u32, out: ptr<function, array<vec2u, 16>>) {
    let at = keyframe.at + 16u * block;
    bc6h_texels(vec4u(word_at(at), word_at(at + 4u), word_at(at + 8u), word_at(at + 12u)), out);
}
`;var Yr=`// Keyframes in BC7 blocks (color.md 4). Mirrors src/codec/color/keyframe_blocks.rs. Needs \`word_at\` and \`bc7_texels\`.

fn keyframe_block(keyframe: Record, block: u32, out: ptr<function, array<u32, 16>>) {
    let at = keyframe.at + 16u * block;
    bc7_texels(vec4u(word_at(at), word_at(at + 4u), word_at(at + 8u), word_at(at + 12u)), out);
}
`;var Qr=`// Cells of 8-bit samples (color.md 3, 4): \`impl Sample for u8\` of src/codec/color/blend.rs. Needs \`word_at\`, \`lerp\` and \`pictures\`.

// Unpacks a pixel from the layout of \`pictures\`: r | g << 8 | b << 16.
fn unpack(pixel: u32) -> vec3u {
    return vec3u(pixel & 255u, (pixel >> 8u) & 255u, (pixel >> 16u) & 255u);
}

fn pack(color: vec3u) -> u32 {
    return color.x | (color.y << 8u) | (color.z << 16u);
}

fn empty_block() -> array<u32, 16> {
    return array<u32, 16>();
}

// Reads a pixel of a raw keyframe: three bytes per pixel.
fn sample_pixel(keyframe: Record, pixel: u32) -> vec3u {
    return unpack(word_at(keyframe.at + 3u * pixel));
}

fn between(a: vec3u, b: vec3u, weight: u32) -> vec3u {
    return lerp(a, b, weight);
}

fn put_pixel(unit: Unit, pixel: u32, color: vec3u) {
    // The row stride may exceed the width.
    pictures[unit.picture + pixel + pixel / unit.width * (unit.stride - unit.width)] = pack(color);
}
`;var Jr=`// Cells of half-float samples (color.md 3, 4). Needs \`word_at\`, \`half_at\`, \`pack\` and \`pictures\`.

fn empty_block() -> array<vec2u, 16> {
    return array<vec2u, 16>();
}

// Reads a pixel of a raw keyframe: three half floats per pixel.
fn sample_pixel(keyframe: Record, pixel: u32) -> vec3u {
    let at = keyframe.at + 6u * pixel;
    return unpack(vec2u(word_at(at), half_at(at + 4u)));
}

fn put_pixel(unit: Unit, pixel: u32, color: vec3u) {
    let words = pack(color);
    let at = unit.picture + 2u * pixel;
    pictures[at] = words.x;
    pictures[at + 1u] = words.y;
}
`;var Zr=`// Declarations of both kernels of the transform codec: the words of a chunk, and the scratch memory of a region, through which
// \`transform-read-…\` passes the decoded blocks to \`transform-…\`. A chunk is a list of words: offset of its table set from the
// first set of the stream; two chroma slopes; number of colours; number of frames; index of the set of frequency offsets; the
// colours, two words each. A region is the step indices of its three channels, then its substream. Needs \`put_pixel\`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> boxes: array<BoxRow>;
@group(0) @binding(4) var<storage, read> stream: array<u32>;
@group(0) @binding(5) var<storage, read> tables: array<u32>;
@group(0) @binding(6) var<storage, read_write> pictures: array<u32>;
@group(0) @binding(7) var<storage, read_write> scratch: array<Scratch>;

// A node of the tree: position in units of 4x4 pixels, size of 4*2^level pixels, first frame in the chunk, number of frames.
struct Block {
    x: u32,
    y: u32,
    level: u32,
    frame: u32,
    frames: u32,
}

// State of the substream reader.
struct Reader {
    // Next element to read: one of NEXT_….
    next: u32,
    // State of the rANS decoder, and the position of the next 16 bits in the stream.
    state: u32,
    next_half: u32,
    node_count: u32,
    // Pixels of the region that no block of the wanted frame has covered yet.
    pixels_left: u32,
    block: Block,
    // Channel of the block that is being read, its number of planes, and its next plane.
    channel: u32,
    plane_count: u32,
    plane: u32,
    // 1 if the previous plane has levels; class of its last position, 0 if it has none.
    coded: u32,
    class_before: u32,
    // Level of the channel's mean, and sum of the DC coefficients in the block's last frame.
    mean_level: i32,
    last_sum: i32,
    // Columns and rows of the channel's coefficients; extents of the block's previous channels, packed as in \`Leaf\`.
    extent: vec2u,
    extents: u32,
    // Number of planes read so far, over all blocks; number of this block's first plane.
    plane_number: u32,
    first_plane_number: u32,
    // Number of planes of the last channel with any, at most 2.
    planes_before: u32,
    // Maximum class of the last position, over the first planes of this block's previous channels.
    first_class: u32,
    // Number of colours of the block's palette; next frame; which half of each byte of \`indices\` holds the previous frame; 1 if
    // the previous frame repeated the one before it.
    color_count: u32,
    next_frame: u32,
    slot: u32,
    frame_repeats: u32,
    // Number of colours in the cache.
    cached: u32,
    // Approximate number of loop iterations in this pass.
    iterations: u32,
}

// A transformed block that shows the wanted frame.
struct Leaf {
    // x | y << 3 | level << 6.
    place: u32,
    // Extents of the three channels, each from bit 10 * channel: columns of coefficients minus 1 | (rows minus 1) << 5.
    extents: u32,
}

// State of a region that is kept between passes and kernels. \`reader\`, \`leaf_count\`, \`magnitudes\` and \`coefficients\` are 0
// before the first pass, and \`transform-…\` resets them to 0. Everything else is written before it is read.
struct Scratch {
    // A colour is two words: keys of red and green, key of blue.
    cache: array<vec2u, 15>,
    palette: array<vec2u, 16>,
    reader: Reader,
    // Stack of nodes to read. Its maximum depth is three quarters of each of three sizes, a half of each of five lengths, and
    // three frames.
    nodes: array<u32, 17>,
    leaf_count: u32,
    leaves: array<Leaf, 64>,
    // Palette indices, a byte per pixel: two frames alternate between the low and the high 4 bits.
    indices: array<u32, 256>,
    // Means of the 4x4 squares, by channel, then row by row.
    means: array<i32, 192>,
    // One word per position, written by the last plane that read it: the plane's number (from bit 8), the maximum magnitude in
    // the first planes of this block's channels (4 bits), and the magnitude (4 bits). There are two extra rows because contexts
    // use neighbours up to two rows below. A neighbour to the right of the last column wraps to the left of a lower row, at a
    // position that this plane has not written yet.
    magnitudes: array<u32, 1088>,
    // Spatial coefficients in units of 2^-(8 + fraction), by channel, then row by row. Those of a block start at its first
    // pixel.
    coefficients: array<i32, 3072>,
}

// Size of a \`Scratch\` in words.
const SCRATCH_WORDS: u32 = 4848u;

const NEXT_OPEN: u32 = 0u;
const NEXT_NODE: u32 = 1u;
const NEXT_CHANNEL: u32 = 2u;
const NEXT_PLANE: u32 = 3u;
const NEXT_FRAME: u32 = 4u;
const NEXT_END: u32 = 5u;

const OFFSET_SET: u32 = 5u;
const COLORS: u32 = 6u;

// Index of this region in \`scratch\`, and first word of its chunk.
var<private> region_slot: u32;
var<private> chunk: u32;
var<private> unit: Unit;
var<private> region: BoxRow;

// Sets the variables above for a region, and returns its record.
fn find_region(number: u32) -> Record {
    region_slot = number;
    let place = job_of(number);
    let job = jobs.list[place];
    let record = records[job.record];
    unit = units[job.unit];
    region = boxes[record.first + number - job_begin(place)];
    chunk = record.at / 4u;
    return record;
}

fn slope_of(channel: u32) -> i32 {
    return i32(stream[chunk + channel]);
}

// Returns the number of fraction bits of a pixel's channels (e in color.md 6).
fn pixel_fraction() -> u32 {
    return select(0u, FINE_BITS, stream[chunk + OFFSET_SET] > 0u);
}

// Returns the index of the first coefficient of a block's channel.
fn coefficients_at(channel: u32, x: u32, y: u32) -> u32 {
    return 1024u * channel + 128u * y + 4u * x;
}

// Writes pixel (x, y) of the region; ignores pixels outside the region.
fn put(x: u32, y: u32, keys: vec3i) {
    if (x < region.width && y < region.height) {
        put_pixel(unit, (region.y + y) * unit.width + region.x + x, sample_of(keys));
    }
}
`;var en=`// Reads symbols and raw bits of a region's substream (color.md 6.6, 7). Mirrors src/codec/color/transform/coder.rs and
// src/codec/entropy/rans.rs. The host has checked that the substream is long enough for everything that is read. Needs \`reader\`,
// \`stream\` and \`tables\`.

// Index in \`tables\` of the first word of the chunk's distributions.
var<private> distributions: u32;

// A substream is a list of words: its initial state, then pairs of 16-bit words.
fn open_substream(word: u32) {
    reader.state = stream[word];
    reader.next_half = 2u * word + 2u;
}

fn renormalise() {
    if (reader.state < 0x10000u) {
        let half = (stream[reader.next_half >> 1u] >> ((reader.next_half & 1u) * 16u)) & 0xffffu;
        reader.state = (reader.state << 16u) | half;
        reader.next_half++;
    }
}

// Returns the first slot of a symbol.
fn start_at(symbol: u32) -> u32 {
    return tables[symbol] & 0xffffu;
}

fn symbol(context: u32) -> u32 {
    let first = distributions + tables[CLUSTERS_AT + context];
    let slot = reader.state & 4095u;
    // Finds the last symbol whose start is at or before the slot. A symbol without slots has the same start as the next one.
    var at = first + select(0u, 8u, start_at(first + 8u) <= slot);
    at += select(0u, 4u, start_at(at + 4u) <= slot);
    at += select(0u, 2u, start_at(at + 2u) <= slot);
    at += select(0u, 1u, start_at(at + 1u) <= slot);
    let slots = tables[at];
    let start = slots & 0xffffu;
    reader.state = ((slots >> 16u) - start) * (reader.state >> 12u) + slot - start;
    renormalise();
    return at - first;
}

fn flag(context: u32) -> bool {
    return symbol(context) == 1u;
}

// Reads at most 12 raw bits.
fn few_bits(count: u32) -> u32 {
    let value = reader.state & ((1u << count) - 1u);
    reader.state >>= count;
    renormalise();
    return value;
}

// Reads at most 24 raw bits.
fn bits(count: u32) -> u32 {
    var high = 0u;
    if (count > 12u) {
        high = few_bits(count - 12u);
    }
    let low = min(count, 12u);
    return (high << low) | few_bits(low);
}

fn number(context: u32) -> u32 {
    let kind = symbol(context);
    if (kind < 12u) {
        return kind;
    }
    var count = kind - 11u;
    var base = 10u;
    if (kind == 15u) {
        count = min(few_bits(5u), 22u);
        base = 25u;
    }
    return (1u << count) + base + bits(count);
}
`;var tn=`// Contexts of symbols (color.md 6.6), and offsets of the format's tables in \`tables\` (src/gpu/transform_tables.rs). Mirrors
// src/codec/color/transform/contexts.rs. Needs \`tables\`.

// First context of each symbol family.
const CONTEXT_NODE: u32 = 0u;
const CONTEXT_PLANES: u32 = 40u;
const CONTEXT_CODED: u32 = 364u;
const CONTEXT_LAST: u32 = 460u;
const CONTEXT_LAST_BITS: u32 = 844u;
const CONTEXT_LEVELS: u32 = 866u;
const CONTEXT_PALETTE_SIZE: u32 = 2162u;
const CONTEXT_PALETTE_COLOR: u32 = 2166u;
const CONTEXT_ROW: u32 = 2167u;
const CONTEXT_PIXEL: u32 = 2169u;
const CONTEXT_LATER_FRAME: u32 = 2185u;
const CONTEXT_LATER_ROW: u32 = 2187u;
const CONTEXT_LATER_PIXEL: u32 = 2189u;

// First word of each table. Words 0 to 96 are an index of the bases: word n, for a basis of n points, holds the length index in
// 8 bits, and the first word of the basis from bit 8. The classes of sums of magnitudes follow.
const SUM_CLASSES_AT: u32 = 97u;
// Scan order of each block size: the position, and its class from bit 16.
const SCAN_AT: u32 = 109u;
// First word of each context's distribution, within a table set.
const CLUSTERS_AT: u32 = 1469u;
// Tables for steps (color.md 6.3): one octave; the inverse roots of the lengths; the frequency offsets of each set, luma then
// chroma.
const OCTAVE_AT: u32 = 3674u;
const ROOTS_AT: u32 = 3690u;
const OFFSETS_AT: u32 = 3699u;

// Returns the index of a number of frames among the transform lengths; the number of lengths if it is none of them.
fn length_index(frames: u32) -> u32 {
    return tables[frames] & 255u;
}

// Returns the first word of a basis. Each row is one basis function.
fn basis_at(points: u32) -> u32 {
    return tables[points] >> 8u;
}

fn scan_at(level: u32) -> u32 {
    // Blocks of 4, 8, 16 and 32 pixels on a side.
    return SCAN_AT + ((16u << (2u * level)) - 16u) / 3u;
}

fn node_context(level: u32, frames: u32) -> u32 {
    return CONTEXT_NODE + 10u * level + length_index(frames);
}

fn planes_context(channel: u32, level: u32, length: u32, before: u32) -> u32 {
    return CONTEXT_PLANES + 3u * (9u * (4u * channel + level) + length) + before;
}

fn coded_context(channel: u32, temporal: u32, level: u32, before: u32) -> u32 {
    return CONTEXT_CODED + 2u * (4u * (4u * channel + temporal) + level) + before;
}

fn last_context(channel: u32, temporal: u32, level: u32, class_before: u32) -> u32 {
    return CONTEXT_LAST + 12u * (4u * (4u * u32(channel > 0u) + level) + temporal) + class_before;
}

fn last_bits_context(channel: u32, logarithm: u32) -> u32 {
    return CONTEXT_LAST_BITS + 11u * u32(channel > 0u) + logarithm;
}

// Returns the first context of a plane's last level; the offset depends on the class of its position and the magnitude in the
// previous plane.
fn last_level_contexts(channel: u32, temporal: u32) -> u32 {
    return CONTEXT_LEVELS + 18u * (4u * u32(channel > 0u) + temporal);
}

// Returns the first context of a plane's other levels; the offset depends on the class of the position, the class of the sum of
// neighbours, and the magnitude in the previous plane.
fn level_contexts(channel: u32, temporal: u32) -> u32 {
    return CONTEXT_LEVELS + 144u + 144u * (4u * u32(channel > 0u) + temporal);
}
`;var rn=`// Conversion between keys and channels (color.md 6.2). Mirrors src/codec/color/transform/domain.rs. Needs \`slope_of\` and \`MIDDLE\`.

fn predicted_chroma(slope: i32, luma: i32) -> i32 {
    return (slope * luma + 8) >> 4u;
}

fn channels_of(keys: vec3i) -> vec3i {
    let orange = keys.x - keys.z;
    let middle = keys.z + (orange >> 1u);
    let green = keys.y - middle;
    let luma = middle + (green >> 1u) - MIDDLE;
    return vec3i(luma, green - predicted_chroma(slope_of(1u), luma), orange - predicted_chroma(slope_of(2u), luma));
}

// Both the channels and the keys are in units of 2^-fraction.
fn keys_of_channels(channels: vec3i, fraction: u32) -> vec3i {
    let chroma_green = channels.y + predicted_chroma(slope_of(1u), channels.x);
    let orange = channels.z + predicted_chroma(slope_of(2u), channels.x);
    let middle = channels.x + (MIDDLE << fraction) - (chroma_green >> 1u);
    let blue = middle - (orange >> 1u);
    return vec3i(blue + orange, chroma_green + middle, blue);
}
`;var nn=`// 8-bit samples in the transform codec: \`Domain::BYTES\` of src/codec/color/transform/domain.rs.

const FRACTION_BITS: u32 = 6u;
// Fraction bits of a pixel's channels in chunks with frequency-dependent steps (offset_set 1).
const FINE_BITS: u32 = 4u;
const KEY_BITS: u32 = 8u;
const MIDDLE: i32 = 128;
const MIN_KEY: i32 = 0;
const MAX_KEY: i32 = 255;

fn sample_of(keys: vec3i) -> vec3u {
    return vec3u(keys);
}
`;var on=`// Half-float samples in the transform codec: \`Domain::HALVES\` of src/codec/color/transform/domain.rs. Needs \`bits_of\`.

const FRACTION_BITS: u32 = 0u;
const FINE_BITS: u32 = 0u;
const KEY_BITS: u32 = 16u;
const MIDDLE: i32 = 0xbc00;
const MIN_KEY: i32 = 0x0400;
const MAX_KEY: i32 = 0xfbff;

fn sample_of(keys: vec3i) -> vec3u {
    return bits_of(vec3u(keys));
}
`;var sn=`// Reads the levels of a transformed block (color.md 6.6), and accumulates the spatial coefficients of one frame while reading.
// Mirrors src/codec/color/transform/levels.rs and \`FrameLevels\` of src/codec/color/transform/reconstruct.rs.

fn open_block() {
    reader.first_plane_number = reader.plane_number + 1u;
    reader.planes_before = 0u;
    reader.first_class = 0u;
    reader.extents = 0u;
    reader.channel = 0u;
    reader.next = NEXT_CHANNEL;
}

// Returns the magnitude of a neighbour in this plane; 0 if it is not read yet.
fn magnitude_at(position: u32) -> u32 {
    let held = scratch[region_slot].magnitudes[position];
    return select(0u, held & 15u, held >> 8u == reader.plane_number);
}

// Reads the scan index of a plane's last nonzero level; the context depends on the class of that index in the previous plane.
fn last_position(channel: u32, temporal: u32, level: u32, class_before: u32) -> u32 {
    let logarithm = symbol(last_context(channel, temporal, level, class_before));
    if (logarithm == 0u) {
        return 0u;
    }
    let high_bits = min(logarithm, 2u);
    let low_bits = logarithm - high_bits;
    let high = symbol(last_bits_context(channel, logarithm)) & ((1u << high_bits) - 1u);
    let index = (1u << logarithm) | (high << low_bits) | few_bits(low_bits);
    return min(index - 1u, (16u << (2u * level)) - 1u);
}

// Reads the number of planes of a channel, and predicts the level of its mean.
fn open_channel() {
    let block = reader.block;
    let channel = reader.channel;
    let length = length_index(block.frames);
    reader.plane_count = min(number(planes_context(channel, block.level, length, reader.planes_before)), block.frames);
    if (channel == 0u || reader.plane_count > 0u) {
        reader.planes_before = min(reader.plane_count, 2u);
    }
    reader.iterations += 3u << (2u * block.level);
    reader.mean_level = predicted_level(block, channel, step_of(channel, length, block.level, 0u));
    reader.last_sum = 0;
    reader.extent = vec2u(1u, 1u);
    reader.coded = 0u;
    reader.class_before = reader.first_class;
    reader.plane = 0u;
    reader.next = NEXT_PLANE;
    if (reader.plane_count == 0u) {
        close_channel();
    }
}

// Reads the levels of a plane. If the block contains the wanted frame, adds their contribution to the coefficients of that
// frame.
fn read_plane() {
    let block = reader.block;
    let channel = reader.channel;
    let plane = reader.plane;
    reader.plane++;
    reader.plane_number++;
    let temporal = select(min(plane, 2u), 3u, block.frames == 1u);
    if (reader.plane < reader.plane_count) {
        reader.coded = symbol(coded_context(channel, temporal, block.level, reader.coded));
        if (reader.coded == 0u) {
            reader.class_before = 0u;
            return;
        }
    }
    let last = last_position(channel, temporal, block.level, reader.class_before);
    reader.class_before = 1u + firstLeadingBit(last + 1u);
    if (plane == 0u) {
        reader.first_class = max(reader.first_class, reader.class_before);
    }
    reader.iterations += last + 1u;
    let length = length_index(block.frames);
    let scan = scan_at(block.level);
    let row = basis_at(block.frames) + plane * block.frames;
    let frame = frame_in(block);
    var weight = 0;
    if (frame != NONE) {
        weight = i32(tables[row + frame]);
    }
    let last_weight = i32(tables[row + block.frames - 1u]);
    let first = coefficients_at(channel, block.x, block.y);
    let last_contexts = last_level_contexts(channel, temporal);
    let contexts = level_contexts(channel, temporal);
    for (var left = last + 1u; left > 0u; left--) {
        let entry = tables[scan + left - 1u];
        let position = entry & 0xffffu;
        let held = scratch[region_slot].magnitudes[position];
        let number_of_held = held >> 8u;
        let channels = select(0u, (held >> 4u) & 15u, number_of_held >= reader.first_plane_number);
        var other = channels;
        if (plane > 0u) {
            other = select(0u, held & 15u, number_of_held + 1u == reader.plane_number);
        }
        other = min(other, 2u);
        let is_last = left == last + 1u;
        var context = last_contexts + 3u * (entry >> 16u) + other;
        if (!is_last) {
            let sum = magnitude_at(position + 1u) + magnitude_at(position + 2u) + magnitude_at(position + 32u)
                + magnitude_at(position + 33u) + magnitude_at(position + 64u);
            let class_of_sum = tables[SUM_CLASSES_AT + min(sum, 11u)];
            context = contexts + 3u * (8u * (entry >> 16u) + class_of_sum) + other;
        }
        let magnitude = number(context) + u32(is_last);
        let counted = min(magnitude, 15u);
        let greatest = select(channels, max(channels, counted), plane == 0u);
        scratch[region_slot].magnitudes[position] = (reader.plane_number << 8u) | (greatest << 4u) | counted;
        if (magnitude == 0u) {
            continue;
        }
        var level = i32(magnitude);
        if (few_bits(1u) == 1u) {
            level = -level;
        }
        reader.extent = max(reader.extent, vec2u(position & 31u, position >> 5u) + 1u);
        if (plane == 0u && position == 0u) {
            reader.mean_level += level;
            continue;
        }
        let frequency = (position & 31u) + (position >> 5u);
        let coefficient = dequantise(level, step_of(channel, length, block.level, frequency));
        if (frame != NONE) {
            scratch[region_slot].coefficients[first + position] += coefficient * weight;
        }
        if (position == 0u) {
            reader.last_sum += coefficient * last_weight;
        }
    }
    reader.coded = 1u;
    if (reader.plane == reader.plane_count) {
        close_channel();
    }
}

// Records the mean of a channel; after the third channel, finishes the block.
fn close_channel() {
    let block = reader.block;
    let channel = reader.channel;
    let mean_step = step_of(channel, length_index(block.frames), block.level, 0u);
    let mean = dequantise(reader.mean_level, mean_step) << 8u;
    note_block(block, channel, reader.last_sum + mean);
    let shows = frame_in(block) != NONE;
    if (shows) {
        scratch[region_slot].coefficients[coefficients_at(channel, block.x, block.y)] += mean;
    }
    reader.extents |= ((reader.extent.x - 1u) | ((reader.extent.y - 1u) << 5u)) << (10u * channel);
    reader.channel++;
    reader.next = NEXT_CHANNEL;
    if (reader.channel < 3u) {
        return;
    }
    reader.next = NEXT_NODE;
    if (shows) {
        let at = scratch[region_slot].leaf_count;
        scratch[region_slot].leaves[at] = Leaf(block.x | (block.y << 3u) | (block.level << 6u), reader.extents);
        scratch[region_slot].leaf_count = at + 1u;
        count_shown(block);
    }
}
`;var an=`// Steps (color.md 6.3), means of 4x4 squares, and the levels predicted from them (color.md 6.5). Mirrors
// src/codec/color/transform/steps.rs and src/codec/color/transform/means.rs.

// Returns the step of a level; \`frequency\` is the sum of its horizontal and vertical frequencies.
fn step_of(channel: u32, length: u32, level: u32, frequency: u32) -> i32 {
    let table = 2u * stream[chunk + OFFSET_SET] + min(channel, 1u);
    let offset = tables[OFFSETS_AT + 64u * table + (((2u * frequency + 1u) << (3u - level)) >> 1u)];
    let index = u32(clamp(i32(stream[region.at / 4u + channel] + offset), 0, 255));
    let mantissa = (tables[OCTAVE_AT + (index & 15u)] * tables[ROOTS_AT + length] + 2048u) >> 12u;
    let shift = 11u - FRACTION_BITS;
    return i32(max(((mantissa << (index >> 4u)) + (1u << (shift - 1u))) >> shift, 1u));
}

fn dequantise(level: i32, step: i32) -> i32 {
    return (level * step + 4) >> 3u;
}

fn first_square(block: Block, channel: u32) -> u32 {
    return 64u * channel + 8u * block.y + block.x;
}

// Returns the predicted level of a block's mean.
fn predicted_level(block: Block, channel: u32, step: i32) -> i32 {
    let first = first_square(block, channel);
    let squares = 1u << block.level;
    let has_left = block.x > 0u;
    let has_above = block.y > 0u;
    var count = squares * squares;
    var shift = 2u * block.level;
    if (block.frame == 0u) {
        count = squares * (u32(has_left) + u32(has_above));
        shift = block.level + u32(has_left && has_above);
    }
    var sum = 0;
    for (var at = 0u; at < count; at++) {
        let x = at & (squares - 1u);
        let y = at >> block.level;
        var square = first + 8u * y + x;
        if (block.frame == 0u) {
            // The squares on the left, then those above.
            square = select(first - 8u + x, first + 8u * x - 1u, has_left && y == 0u);
        }
        sum += scratch[region_slot].means[square];
    }
    let scaled = (sum >> shift) * i32(32u << block.level) + (step >> 1u);
    // Division that rounds down.
    let quotient = scaled / step;
    return quotient - i32(scaled - quotient * step < 0);
}

fn note_square(square: u32, channels: vec3i) {
    scratch[region_slot].means[square] = channels.x;
    scratch[region_slot].means[64u + square] = channels.y;
    scratch[region_slot].means[128u + square] = channels.z;
}

// Records the mean of a block, computed from the sum of its DC coefficients in its last frame.
fn note_block(block: Block, channel: u32, sum: i32) {
    let mean = ((sum + 128) >> 8u) >> (2u + block.level);
    let first = first_square(block, channel);
    for (var at = 0u; at < (1u << (2u * block.level)); at++) {
        scratch[region_slot].means[first + 8u * (at >> block.level) + (at & ((1u << block.level) - 1u))] = mean;
    }
}
`;var cn=`// Palette blocks (color.md 6.8). Mirrors src/codec/color/transform/palette.rs.

fn index_in(position: u32, of_slot: u32) -> u32 {
    return (scratch[region_slot].indices[position >> 2u] >> (8u * (position & 3u) + 4u * of_slot)) & 15u;
}

fn put_index(position: u32, index: u32) {
    let shift = 8u * (position & 3u) + 4u * reader.slot;
    let held = scratch[region_slot].indices[position >> 2u];
    scratch[region_slot].indices[position >> 2u] = (held & ~(15u << shift)) | (index << shift);
}

// Initialises the cache with the chunk's colours and fills the remaining entries with 0.
fn open_cache() {
    reader.cached = stream[chunk + 3u];
    for (var at = 0u; at < 15u; at++) {
        var color = vec2u();
        if (at < reader.cached) {
            let first = chunk + COLORS + 2u * at;
            color = vec2u(stream[first], stream[first + 1u]);
        }
        scratch[region_slot].cache[at] = color;
    }
}

// Moves a colour to the front of the cache. If the colour is new and the cache is full, drops the last entry.
fn touch(color: vec2u) {
    var moved = color;
    var at = 0u;
    loop {
        let held = scratch[region_slot].cache[at];
        scratch[region_slot].cache[at] = moved;
        moved = held;
        if (at == min(reader.cached, 14u) || all(held == color)) {
            break;
        }
        at++;
    }
    reader.cached = max(reader.cached, at + 1u);
}

fn open_palette(level: u32) {
    reader.color_count = symbol(CONTEXT_PALETTE_SIZE + level) + 1u;
    for (var at = 0u; at < reader.color_count; at++) {
        let place = symbol(CONTEXT_PALETTE_COLOR);
        if (place < 15u) {
            scratch[region_slot].palette[at] = scratch[region_slot].cache[place];
        } else {
            let red = bits(KEY_BITS);
            let green = bits(KEY_BITS);
            scratch[region_slot].palette[at] = vec2u(red | (green << 16u), bits(KEY_BITS));
        }
    }
    for (var at = reader.color_count; at > 0u; at--) {
        touch(scratch[region_slot].palette[at - 1u]);
    }
    reader.next_frame = 0u;
    reader.slot = 0u;
    reader.frame_repeats = 0u;
    reader.iterations += 17u * reader.color_count;
    reader.next = NEXT_FRAME;
}

// Reads a palette index. A symbol below the number of distinct values among a, b and c selects one of these values; otherwise
// the index follows as raw bits.
fn read_index(context: u32, a: u32, b: u32, c: u32) -> u32 {
    let place = symbol(context);
    var second = b;
    var third = c;
    var count = 1u + u32(b != a);
    if (c != a && c != b) {
        if (count == 1u) {
            second = c;
        }
        count++;
    }
    if (place >= count) {
        return few_bits(firstLeadingBit(reader.color_count - 1u) + 1u);
    }
    return select(select(third, second, place == 1u), a, place == 0u);
}

// Reads the indices of a frame, row by row. Those of the previous frame, if any, are in the other slot.
fn read_indices(side: u32, is_first: bool) {
    let before = reader.slot ^ 1u;
    var repeats = false;
    for (var number = 0u; number < side * side; number++) {
        let x = number % side;
        let y = number / side;
        let at = 32u * y + x;
        if (x == 0u && !(is_first && y == 0u)) {
            repeats = flag(select(CONTEXT_LATER_ROW, CONTEXT_ROW, is_first) + u32(repeats));
        }
        var held = 0u;
        if (!is_first) {
            held = index_in(at, before);
        }
        var above = held;
        if (y > 0u) {
            above = index_in(at - 32u, reader.slot);
        }
        if (repeats) {
            put_index(at, select(held, above, is_first));
            continue;
        }
        var left = above;
        if (x > 0u) {
            left = index_in(at - 1u, reader.slot);
        }
        if (y == 0u) {
            above = left;
        }
        if (is_first) {
            var above_left = above;
            if (x > 0u && y > 0u) {
                above_left = index_in(at - 33u, reader.slot);
            }
            var above_right = above;
            if (y > 0u && x + 1u < side) {
                above_right = index_in(at - 31u, reader.slot);
            }
            let context = u32(left == above) | (u32(above_left == left) << 1u) | (u32(above_left == above) << 2u)
                | (u32(above_right == above) << 3u);
            put_index(at, read_index(CONTEXT_PIXEL + context, left, above, above));
        } else {
            let left_changed = x > 0u && left != index_in(at - u32(x > 0u), before);
            let above_changed = y > 0u && above != index_in(at - select(0u, 32u, y > 0u), before);
            let context = u32(left_changed) | (u32(above_changed) << 1u) | (u32(left == held) << 2u)
                | (u32(above == held) << 3u);
            put_index(at, read_index(CONTEXT_LATER_PIXEL + context, held, left, above));
        }
    }
}

// Reads the indices of the next frame, or that it repeats the previous one.
fn read_next_indices(side: u32) {
    let is_first = reader.next_frame == 0u;
    reader.next_frame++;
    if (reader.color_count == 1u) {
        return;
    }
    if (!is_first) {
        reader.frame_repeats = symbol(CONTEXT_LATER_FRAME + reader.frame_repeats);
        if (reader.frame_repeats == 1u) {
            return;
        }
        reader.slot ^= 1u;
    }
    reader.iterations += side * side;
    read_indices(side, is_first);
}

// Reads the next frame of a palette block, and writes its pixels if it is the wanted frame. After the last frame, records the
// means.
fn read_frame() {
    let block = reader.block;
    let side = 4u << block.level;
    if (reader.next_frame == block.frames) {
        note_palette(block);
        reader.next = NEXT_NODE;
        return;
    }
    read_next_indices(side);
    if (reader.next_frame == frame_in(block) + 1u) {
        reader.iterations += side * side;
        for (var at = 0u; at < side * side; at++) {
            let x = at & (side - 1u);
            let y = at >> (2u + block.level);
            put(4u * block.x + x, 4u * block.y + y, palette_keys(x, y));
        }
        count_shown(block);
    }
}

fn keys_of_color(color: vec2u) -> vec3i {
    return vec3i(vec3u(color.x & 0xffffu, color.x >> 16u, color.y));
}

// Returns the keys of a pixel of the palette block.
fn palette_keys(x: u32, y: u32) -> vec3i {
    var index = 0u;
    if (reader.color_count > 1u) {
        index = index_in(32u * y + x, reader.slot);
    }
    return keys_of_color(scratch[region_slot].palette[index]);
}

// Records the means of the palette block (color.md 6.5).
fn note_palette(block: Block) {
    let squares = 1u << block.level;
    reader.iterations += 18u * squares * squares;
    for (var square = 0u; square < squares * squares; square++) {
        let x = square & (squares - 1u);
        let y = square >> block.level;
        var sums = vec3i(0);
        for (var at = 0u; at < 16u; at++) {
            sums += palette_keys(4u * x + at % 4u, 4u * y + at / 4u);
        }
        let channels = channels_of((sums + 8) >> vec3u(4u)) << vec3u(FRACTION_BITS);
        note_square(first_square(block, 0u) + 8u * y + x, channels);
    }
}
`;var un=`// Inverse transform of one frame of a region (color.md 6.3), one workgroup per region: all invocations transform one block at a
// time. Mirrors src/codec/color/transform/reconstruct.rs.

// Coefficients after the column transform, 32 per row.
var<workgroup> columns: array<i32, 1024>;
var<workgroup> leaf_count: u32;
var<workgroup> next: u32;
var<workgroup> leaves: array<Leaf, 64>;

// Luma and green chroma of this invocation's pixels.
var<private> luma: array<i32, 16>;
var<private> green: array<i32, 16>;

// Returns the number of columns and rows of a channel's coefficients.
fn extent_of(leaf: Leaf, channel: u32) -> vec2u {
    return ((vec2u(leaf.extents) >> vec2u(10u * channel, 10u * channel + 5u)) & vec2u(31u)) + 1u;
}

fn transform_columns(local: u32, level: u32, first: u32, extent: vec2u) {
    let side = 4u << level;
    let functions = basis_at(side);
    let columns_bits = firstLeadingBit(2u * extent.x - 1u);
    for (var at = local; at < (side << columns_bits); at += WORKGROUP) {
        let x = at & ((1u << columns_bits) - 1u);
        let y = at >> columns_bits;
        var sum = 128;
        for (var k = 0u; k < extent.y; k++) {
            let coefficient = scratch[region_slot].coefficients[first + 32u * k + x];
            sum += ((coefficient + 128) >> 8u) * i32(tables[functions + side * k + y]);
        }
        columns[32u * y + x] = sum >> 8u;
    }
}

fn transform_rows(local: u32, place: vec2u, level: u32, channel: u32, column_count: u32) {
    let side = 4u << level;
    let functions = basis_at(side);
    let fraction = pixel_fraction();
    let shift = 10u + FRACTION_BITS - fraction + level;
    for (var turn = 0u; turn * WORKGROUP + local < side * side; turn++) {
        let at = turn * WORKGROUP + local;
        let x = at & (side - 1u);
        let y = at >> (2u + level);
        var sum = 1 << (shift - 1u);
        for (var k = 0u; k < column_count; k++) {
            sum += columns[32u * y + k] * i32(tables[functions + side * k + x]);
        }
        let value = sum >> shift;
        if (channel == 0u) {
            luma[turn] = value;
        } else if (channel == 1u) {
            green[turn] = value;
        } else {
            let fine = keys_of_channels(vec3i(luma[turn], green[turn], value), fraction);
            let keys = (fine + ((1 << fraction) >> 1u)) >> vec3u(fraction);
            put(4u * place.x + x, 4u * place.y + y, clamp(keys, vec3i(MIN_KEY), vec3i(MAX_KEY)));
        }
    }
}

fn clear_coefficients(local: u32, first: u32, extent: vec2u) {
    let columns_bits = firstLeadingBit(2u * extent.x - 1u);
    for (var at = local; at < (extent.y << columns_bits); at += WORKGROUP) {
        scratch[region_slot].coefficients[first + 32u * (at >> columns_bits) + (at & ((1u << columns_bits) - 1u))] = 0;
    }
}

// Resets the fields that must be 0 before the next frame.
fn clear_scratch(local: u32) {
    for (var at = local; at < 1088u; at += WORKGROUP) {
        scratch[region_slot].magnitudes[at] = 0u;
    }
    if (local == 0u) {
        scratch[region_slot].reader = Reader();
        scratch[region_slot].leaf_count = 0u;
    }
}

@compute @workgroup_size(WORKGROUP)
fn show_regions(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let number = group.x + group.y * groups.x;
    if (number >= jobs.total) {
        return;
    }
    _ = find_region(number);
    leaves[local] = scratch[region_slot].leaves[local];
    if (local == 0u) {
        leaf_count = scratch[region_slot].leaf_count;
        next = scratch[region_slot].reader.next;
    }
    let count = workgroupUniformLoad(&leaf_count);
    for (var at = 0u; at < count; at++) {
        let leaf = workgroupUniformLoad(&leaves[at]);
        let place = vec2u(leaf.place & 7u, (leaf.place >> 3u) & 7u);
        let level = leaf.place >> 6u;
        for (var channel = 0u; channel < 3u; channel++) {
            let first = coefficients_at(channel, place.x, place.y);
            let extent = extent_of(leaf, channel);
            transform_columns(local, level, first, extent);
            workgroupBarrier();
            transform_rows(local, place, level, channel, extent.x);
            clear_coefficients(local, first, extent);
            workgroupBarrier();
        }
    }
    if (workgroupUniformLoad(&next) != NEXT_END) {
        // Reading stopped early: the block that was being read has coefficients but is not in \`leaves\`.
        for (var at = local; at < 3072u; at += WORKGROUP) {
            scratch[region_slot].coefficients[at] = 0;
        }
    }
    clear_scratch(local);
}
`;var ln=`// Reads the block tree of a region (color.md 6.4), one region per invocation. Mirrors src/codec/color/transform/region.rs and
// src/codec/color/transform/blocks.rs. A long region takes several passes; reading ends when all pixels of the wanted frame are
// known.

const NODE_QUARTERS: u32 = 1u;
const NODE_PARTS: u32 = 2u;
const NODE_PALETTE: u32 = 3u;

// Iterations after which a pass ends. Mesa's software Vulkan terminates all loops of 8 invocations after 65535 iterations in
// total, and a loop that none of them enters counts as one. A step counts its own iterations plus STEP_ITERATIONS, the number
// of loops in \`read_regions\`; the longest step, a frame of a palette, counts 2060. So 8 invocations take at most 8 * (4999 +
// 2060) iterations. The host counts passes with the same numbers.
const PASS_ITERATIONS: u32 = 5000u;
const STEP_ITERATIONS: u32 = 12u;

var<private> reader: Reader;
var<private> wanted_frame: u32;

fn push_node(x: u32, y: u32, level: u32, frame: u32, frames: u32) {
    scratch[region_slot].nodes[reader.node_count] = x | (y << 3u) | (level << 6u) | (frame << 8u) | (frames << 16u);
    reader.node_count++;
}

fn node_of(word: u32) -> Block {
    return Block(word & 7u, (word >> 3u) & 7u, (word >> 6u) & 3u, (word >> 8u) & 255u, word >> 16u);
}

fn open_region() {
    open_substream(region.at / 4u + 3u);
    let squares = (max(region.width, region.height) + 3u) / 4u;
    let level = firstLeadingBit(2u * squares - 1u);
    push_node(0u, 0u, level, 0u, stream[chunk + 4u]);
    reader.pixels_left = 16u << (2u * level);
    open_cache();
    reader.next = NEXT_NODE;
}

fn push_children(block: Block, kind: u32) {
    if (kind == NODE_QUARTERS) {
        let level = block.level - 1u;
        let half = 1u << level;
        push_node(block.x + half, block.y + half, level, block.frame, block.frames);
        push_node(block.x, block.y + half, level, block.frame, block.frames);
        push_node(block.x + half, block.y, level, block.frame, block.frames);
        push_node(block.x, block.y, level, block.frame, block.frames);
    } else if (block.frames == 3u) {
        push_node(block.x, block.y, block.level, block.frame + 2u, 1u);
        push_node(block.x, block.y, block.level, block.frame + 1u, 1u);
        push_node(block.x, block.y, block.level, block.frame, 1u);
    } else {
        let first = (block.frames + 1u) / 2u;
        push_node(block.x, block.y, block.level, block.frame + first, block.frames - first);
        push_node(block.x, block.y, block.level, block.frame, first);
    }
}

fn read_node() {
    if (reader.node_count == 0u) {
        reader.next = NEXT_END;
        return;
    }
    reader.node_count--;
    reader.block = node_of(scratch[region_slot].nodes[reader.node_count]);
    let kind = symbol(node_context(reader.block.level, reader.block.frames));
    if (kind == NODE_PALETTE) {
        open_palette(reader.block.level);
    } else if (kind == NODE_QUARTERS || kind == NODE_PARTS) {
        push_children(reader.block, kind);
    } else {
        open_block();
    }
}

// Subtracts the pixels of a block that shows the wanted frame; ends reading when none remain.
fn count_shown(block: Block) {
    reader.pixels_left -= 16u << (2u * block.level);
    if (reader.pixels_left == 0u) {
        reader.next = NEXT_END;
    }
}

// Returns the index of the wanted frame in a block; NONE if the block does not contain it.
fn frame_in(block: Block) -> u32 {
    let frame = wanted_frame - block.frame;
    return select(NONE, frame, frame < block.frames);
}

@compute @workgroup_size(WORKGROUP)
fn read_regions(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = invocation_of(id, groups);
    if (number >= jobs.total || scratch[number].reader.next == NEXT_END) {
        return;
    }
    let record = find_region(number);
    distributions = unit.base + stream[chunk];
    wanted_frame = record.frame;
    reader = scratch[region_slot].reader;
    if (reader.next == NEXT_OPEN) {
        open_region();
    }
    reader.iterations = 0u;
    while (reader.next != NEXT_END && reader.iterations < PASS_ITERATIONS) {
        reader.iterations += STEP_ITERATIONS;
        switch (reader.next) {
            case NEXT_CHANNEL: {
                open_channel();
            }
            case NEXT_PLANE: {
                read_plane();
            }
            case NEXT_FRAME: {
                read_frame();
            }
            default: {
                read_node();
            }
        }
    }
    scratch[region_slot].reader = reader;
}
`;var dn=`// BC4w blocks (depth.md 8). Mirrors src/codec/depth/bc4w.rs. Needs \`stream\`.

struct Bc4w {
    // 13-bit endpoints of sides A and B.
    a: vec2u,
    b: vec2u,
    // Endpoints of the line: x0, y0, x1, y1.
    line: vec4i,
}

fn bc4w_at(at: u32) -> Bc4w {
    let low = stream[at + 6u];
    let high = stream[at + 7u];
    let a = vec2u(low & 8191u, (low >> 13u) & 8191u);
    let b = vec2u(((low >> 26u) | (high << 6u)) & 8191u, (high >> 7u) & 8191u);
    let line = (vec4u(high) >> vec4u(20u, 23u, 26u, 29u)) & vec4u(7u);
    return Bc4w(a, b, vec4i(line));
}

// Returns the 16-bit code of a 3-bit index between two 13-bit endpoints.
fn palette_code(endpoints: vec2u, index: u32) -> u32 {
    let d = (endpoints << vec2u(3u)) | (endpoints >> vec2u(10u));
    if (index == 0u) {
        return d.x;
    }
    if (index == 1u) {
        return d.y;
    }
    if (endpoints.x > endpoints.y) {
        return ((8u - index) * d.x + (index - 1u) * d.y + 3u) / 7u;
    }
    if (index == 6u) {
        return 0u;
    }
    if (index == 7u) {
        return 65535u;
    }
    return ((6u - index) * d.x + (index - 1u) * d.y + 2u) / 5u;
}

// Returns the code of pixel (x, y), both 0 to 7, of the block whose first word is at \`at\`.
fn bc4w_code(block: Bc4w, at: u32, x: u32, y: u32) -> u32 {
    let bit = 24u * y + 3u * x;
    let shift = bit & 31u;
    var index = stream[at + (bit >> 5u)] >> shift;
    if (shift > 29u) {
        index |= stream[at + (bit >> 5u) + 1u] << (32u - shift);
    }
    let p = vec2i(i32(x), i32(y)) - block.line.xy;
    let d = block.line.zw - block.line.xy;
    return palette_code(select(block.a, block.b, d.x * p.y - d.y * p.x > 0), index & 7u);
}
`;var fn=`// Biquadratic functions (arithmetic.md 6). Mirrors src/codec/depth/biquadratic.rs. Needs \`stream\`.

struct Biquadratic {
    a0: i32,
    a1: i32,
    a2: i32,
    a3: i32,
    a4: i32,
    a5: i32,
}

fn biquadratic_at(at: u32) -> Biquadratic {
    return Biquadratic(
        bitcast<i32>(stream[at]),
        bitcast<i32>(stream[at + 1u]),
        bitcast<i32>(stream[at + 2u]),
        bitcast<i32>(stream[at + 3u]),
        bitcast<i32>(stream[at + 4u]),
        bitcast<i32>(stream[at + 5u]),
    );
}

// Evaluates the function at a pixel, in Q14 with wrapping arithmetic.
fn biquadratic_value(f: Biquadratic, x: i32, y: i32) -> i32 {
    let u = f.a0 + ((f.a2 * y + f.a3 * x + 128) >> 8u);
    let v = f.a1 + ((f.a4 * y + 128) >> 8u);
    return f.a5 + u * x + v * y;
}
`;var hn=`// Block tiles of block-compressed boxes (depth.md 14): finds the block that holds a pixel. Mirrors src/codec/depth/block_tiles.rs;
// the table of boxes has one row per piece.

// Returns the index of the block that holds a pixel of a piece, and the index of the pixel in that block.
fn piece_block(row: BoxRow, x: u32, y: u32) -> vec2u {
    let columns = (row.width + 3u) / 4u;
    return vec2u(y / 4u * columns + x / 4u, y % 4u * 4u + x % 4u);
}
`;var mn=`// Block tiles in BC1 blocks or as raw values (depth.md 14): \`impl Texel for [u8; 3]\` of src/codec/depth/texel.rs. Needs
// \`piece_block\`, \`word_at\`, \`stored_value\` and \`bc1_texel\`.

fn box_value(row: BoxRow, x: u32, y: u32) -> u32 {
    if (row.coding != BOX_BLOCKS) {
        return stored_value(row, x, y);
    }
    let place = piece_block(row, x, y);
    let at = row.at + 8u * place.x;
    return bc1_texel(vec2u(word_at(at), word_at(at + 4u)), place.y);
}
`;var pn=`// Block tiles in BC5 blocks or as raw values (depth.md 14): \`impl Texel for u16\` of src/codec/depth/texel.rs. Needs \`piece_block\`,
// \`word_at\`, \`stored_value\` and \`bc5_texel\`.

fn box_value(row: BoxRow, x: u32, y: u32) -> u32 {
    if (row.coding != BOX_BLOCKS) {
        return stored_value(row, x, y);
    }
    let place = piece_block(row, x, y);
    let at = row.at + 16u * place.x;
    let texel = bc5_texel(vec4u(word_at(at), word_at(at + 4u), word_at(at + 8u), word_at(at + 12u)), place.y);
    // Red is the high byte.
    return ((texel & 255u) << 8u) | (texel >> 8u);
}
`;var bn=`// Boxes without block compression (depth.md 4). Needs \`stored_value\`.

fn box_value(row: BoxRow, x: u32, y: u32) -> u32 {
    return stored_value(row, x, y);
}
`;var wn=`// Converts the value of a modelling function to a code (arithmetic.md 6, 7). Mirrors src/codec/depth/domain.rs. Needs \`log2_table\`.

const BACKGROUND_CODE: u32 = 65535u;
const FAR_CODE: u32 = 65534u;

fn code_of(unit: Unit, r: i32) -> u32 {
    switch unit.domain {
        case DOMAIN_LINEAR: {
            return linear_code(unit, r);
        }
        case DOMAIN_INVERSE: {
            return inverse_code(unit, r);
        }
        default: {
            return log_code(r);
        }
    }
}

fn log_code(r: i32) -> u32 {
    return u32(clamp((r + 8192) >> 14u, 0, 65535));
}

fn linear_code(unit: Unit, r: i32) -> u32 {
    let value = q8(r);
    if (value >= 16777216) {
        return BACKGROUND_CODE;
    }
    let log = integer_log2(u32(max(value, 1)));
    return scaled(log - min(log, unit.base), unit.scale);
}

fn inverse_code(unit: Unit, r: i32) -> u32 {
    let value = q8(r);
    if (value <= 0) {
        return BACKGROUND_CODE;
    }
    let log = integer_log2(u32(min(value, 16777215)));
    return scaled(unit.base - min(unit.base, log), unit.scale);
}

// Converts Q14 to Q8, rounding to nearest.
fn q8(r: i32) -> i32 {
    return (r + 32) >> 6u;
}

// Returns log2 in Q24.
fn integer_log2(value: u32) -> u32 {
    let exponent = firstLeadingBit(value);
    let fraction = ((value << (31u - exponent)) << 1u) >> 9u;
    let index = fraction >> 15u;
    let rest = fraction & 0x7fffu;
    let low = log2_table[index];
    let high = log2_table[index + 1u];
    return (exponent << 24u) + low + (((high - low) * rest + 0x4000u) >> 15u);
}

// Returns (log · scale + 2³¹) >> 32, at most FAR_CODE.
fn scaled(log: u32, scale: u32) -> u32 {
    let found = product(log, scale);
    // Adding 2³¹ carries into the high word if bit 31 of the low word is set.
    return min(found.y + (found.x >> 31u), FAR_CODE);
}
`;var gn=`// Platelets: two planes divided by a line (arithmetic.md 6). Mirrors src/codec/depth/platelet.rs. Needs \`stream\`.

struct Plane {
    a0: i32,
    a1: i32,
    a5: i32,
}

// Side test of the line: a pixel is on side B if the value is positive.
struct SideTest {
    start: i32,
    across: i32,
    down: i32,
}

struct Platelet {
    a: Plane,
    b: Plane,
    test: SideTest,
}

fn side_test(line: u32, level: u32) -> SideTest {
    let units = 8i << level;
    let shared_units = min(units, 256);
    let of_pixels = 256 / shared_units;
    let of_points = units / shared_units;
    let x0 = i32(line & 255u);
    let y0 = i32((line >> 8u) & 255u);
    let dx = i32((line >> 16u) & 255u) - x0;
    let dy = i32(line >> 24u) - y0;
    let start = dx * (of_pixels - y0 * of_points) - dy * (of_pixels - x0 * of_points);
    return SideTest(start, -dy * 2 * of_pixels, dx * 2 * of_pixels);
}

fn plane_at(at: u32) -> Plane {
    return Plane(bitcast<i32>(stream[at]), bitcast<i32>(stream[at + 1u]), bitcast<i32>(stream[at + 2u]));
}

fn platelet_at(at: u32, level: u32) -> Platelet {
    return Platelet(plane_at(at), plane_at(at + 3u), side_test(stream[at + 6u], level));
}

// Evaluates the function at a pixel, in Q14 with wrapping arithmetic.
fn platelet_value(f: Platelet, x: i32, y: i32) -> i32 {
    var side = f.a;
    if (f.test.start + f.test.across * x + f.test.down * y > 0) {
        side = f.b;
    }
    return side.a5 + side.a0 * x + side.a1 * y;
}
`;var yn=`// Plans depth units: the record that each listed unit applies next, and its amount of work (depth.md 4). A dispatch plans one
// step per unit. Mirrors src/codec/depth/record_table.rs.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> chunks: array<Chunk>;
@group(0) @binding(2) var<storage, read> records: array<Record>;
@group(0) @binding(3) var<storage, read> items: Items;
@group(0) @binding(4) var<storage, read_write> states: array<State>;
@group(0) @binding(5) var<storage, read_write> jobs: Jobs;
@group(0) @binding(6) var<storage, read_write> dispatch: Dispatch;

// Frame on which a step ends, and the record of that frame; NONE if it has no record.
struct Landing {
    frame: u32,
    record: u32,
}

// Returns the index in the chunk of the first record whose frame is at or after \`frame\`.
fn records_below(chunk: Chunk, frame: u32) -> u32 {
    var low = 0u;
    var high = chunk.record_count;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (records[chunk.first_record + middle].frame < frame) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// Steps by at most \`window\` frames until a step ends on a record or on the target. A window of 0 goes directly to the target.
fn land(chunk: Chunk, start: u32, target_frame: u32, window: u32) -> Landing {
    var frame = start;
    while (frame < target_frame) {
        if (window == 0u) {
            frame = target_frame;
        } else {
            // Skips all steps that end on no record at once: they change nothing.
            let next = records_below(chunk, frame + 1u);
            var stop = target_frame;
            if (next < chunk.record_count) {
                stop = min(stop, records[chunk.first_record + next].frame);
            }
            frame += (stop - frame - 1u) / window * window;
            frame += min(window, target_frame - frame);
        }
        let found = records_below(chunk, frame);
        if (found < chunk.record_count && records[chunk.first_record + found].frame == frame) {
            return Landing(frame, chunk.first_record + found);
        }
    }
    return Landing(target_frame, NONE);
}

fn next_record(item: Item) -> u32 {
    let chunk = chunks[item.chunk];
    let window = units[item.unit].window;
    let state = states[item.unit];
    var landing: Landing;
    if (state.key == item.key && state.frame <= item.frame) {
        landing = land(chunk, state.frame, item.frame, window);
    } else if (window == 0u && item.frame > 0u) {
        landing = land(chunk, 0u, item.frame, window);
    } else {
        landing = Landing(0u, chunk.first_record);
    }
    // If no further record follows, the target frame is reached.
    let more = land(chunk, landing.frame, item.frame, window);
    let frame = select(landing.frame, item.frame, more.record == NONE);
    states[item.unit] = State(item.key, frame, 0u);
    return landing.record;
}

@compute @workgroup_size(SUM_WORKGROUP)
fn plan_records(@builtin(local_invocation_index) local: u32) {
    var before = 0u;
    for (var first = 0u; first < items.count; first += SUM_WORKGROUP) {
        let at = first + local;
        var record = NONE;
        var work = 0u;
        if (at < items.count) {
            record = next_record(items.list[at]);
            if (record != NONE) {
                work = records[record].work;
            }
        }
        let end = before + running_sum(local, work);
        if (at < items.count) {
            jobs.list[at] = Job(items.list[at].unit, end, record, NONE, 0u);
        }
        before += sums[SUM_WORKGROUP - 1u];
    }
    if (local == 0u) {
        finish_plan(before);
    }
}
`;var _n=`// Records of boxes (depth.md 4). Mirrors src/codec/depth/records.rs. Needs \`units\`, \`records\`, \`jobs\` and \`boxes\`.

// The part of a box that one invocation writes.
struct BoxPart {
    unit: u32,
    row: u32,
    // Index of the part in its box.
    part: u32,
}

fn box_part(invocation: u32) -> BoxPart {
    let number = job_of(invocation);
    let job = jobs.list[number];
    let record = records[job.record];
    let part = invocation - job_begin(number);
    var low = record.first;
    var high = record.first + record.count;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (boxes[middle].end <= part) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    var begin = 0u;
    if (low > record.first) {
        begin = boxes[low - 1u].end;
    }
    return BoxPart(job.unit, low, part - begin);
}
`;var vn=`// Decodes nodes in the runtime form (depth.md 10; GDC 4, 5). Mirrors src/codec/depth/runtime.rs and src/codec/depth/nodes.rs.
//
// An invocation decodes a part of 4x4 pixels. The parts of a record are numbered by level, then by node, then row by row inside
// a node. The node of a part follows from the node counts in the header.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> stream: array<u32>;
@group(0) @binding(4) var<storage, read> log2_table: array<u32>;
@group(0) @binding(5) var<storage, read_write> pictures: array<u32>;

// Writes four codes of a row; skips those outside the picture.
fn write_row(unit: Unit, x: u32, y: u32, codes: vec4u) {
    if (y >= unit.height) {
        return;
    }
    let inside = select(vec4u(0u), codes, vec4u(x, x + 1u, x + 2u, x + 3u) < vec4u(unit.width));
    let at = unit.picture + y * unit.stride + x / 2u;
    if (x < unit.width) {
        pictures[at] = inside.x | (inside.y << 16u);
    }
    if (x + 2u < unit.width) {
        pictures[at + 1u] = inside.z | (inside.w << 16u);
    }
}

// Decodes the 4x4 pixels at \`corner\` of the node whose first pixel is \`origin\` and whose coefficients start at word \`at\`.
fn decode_part(unit: Unit, level: u32, at: u32, origin: vec2u, corner: vec2u) {
    let p = origin + corner;
    if (level == 0u) {
        for (var y = 0u; y < 4u; y++) {
            let pairs = vec2u(stream[at + 2u * y], stream[at + 2u * y + 1u]);
            write_row(unit, p.x, p.y + y, vec4u(pairs.x & 0xffffu, pairs.x >> 16u, pairs.y & 0xffffu, pairs.y >> 16u));
        }
        return;
    }
    if (stream[at + 7u] != NONE) {
        let block = bc4w_at(at);
        for (var y = 0u; y < 4u; y++) {
            var codes: vec4u;
            for (var x = 0u; x < 4u; x++) {
                codes[x] = bc4w_code(block, at, corner.x + x, corner.y + y);
            }
            write_row(unit, p.x, p.y + y, codes);
        }
        return;
    }
    if (stream[at + 6u] != NONE) {
        let platelet = platelet_at(at, level);
        for (var y = 0u; y < 4u; y++) {
            var codes: vec4u;
            for (var x = 0u; x < 4u; x++) {
                codes[x] = code_of(unit, platelet_value(platelet, i32(corner.x + x), i32(corner.y + y)));
            }
            write_row(unit, p.x, p.y + y, codes);
        }
        return;
    }
    let surface = biquadratic_at(at);
    for (var y = 0u; y < 4u; y++) {
        var codes: vec4u;
        for (var x = 0u; x < 4u; x++) {
            codes[x] = code_of(unit, biquadratic_value(surface, i32(corner.x + x), i32(corner.y + y)));
        }
        write_row(unit, p.x, p.y + y, codes);
    }
}

@compute @workgroup_size(WORKGROUP)
fn decode_nodes(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let unit = units[job.unit];
    let header = records[job.record].at;
    var part = invocation - job_begin(number);
    var node = 0u;
    var level = 0u;
    while (level + 1u < LEVELS) {
        let nodes = stream[header + 1u + level];
        let parts = nodes << (2u * level);
        if (part < parts) {
            break;
        }
        part -= parts;
        node += nodes;
        level++;
    }
    node += part >> (2u * level);
    part &= (1u << (2u * level)) - 1u;
    let places_at = header + NODE_HEADER_WORDS;
    let place = stream[places_at + node / 2u] >> (16u * (node & 1u));
    // Positions take two bytes each and are padded to a multiple of 16 bytes.
    let coefficients_at = places_at + (2u * stream[header] + 15u) / 16u * 4u + 8u * node;
    let origin = vec2u(place & 255u, (place >> 8u) & 255u) << vec2u(level + 2u);
    let corner = vec2u(part & ((1u << level) - 1u), part >> level) * 4u;
    decode_part(unit, level, coefficients_at, origin, corner);
}
`;var xn=`// Boxes of depth codes (depth.md 4). Mirrors \`impl Texel for u16\` of src/codec/depth/texel.rs.
//
// An invocation writes a word: two codes, or only the one inside the box. Another box of the record may write the other half of
// the same word, so a single half is written with atomic bit operations. Needs \`box_value\`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> boxes: array<BoxRow>;
@group(0) @binding(4) var<storage, read> stream: array<u32>;
@group(0) @binding(5) var<storage, read_write> pictures: array<atomic<u32>>;

// Reads the code at column x and row y of a box that is not block-compressed.
fn stored_value(row: BoxRow, x: u32, y: u32) -> u32 {
    if (row.coding == BOX_CONSTANT) {
        return half_at(row.at);
    }
    return half_at(row.at + 2u * (y * row.width + x));
}

@compute @workgroup_size(WORKGROUP)
fn decode_codes(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let found = box_part(invocation);
    let unit = units[found.unit];
    let row = boxes[found.row];
    let first = row.x / 2u;
    let words = (row.x + row.width + 1u) / 2u - first;
    let y = found.part / words;
    let word = first + found.part % words;
    let at = unit.picture + (row.y + y) * unit.stride + word;
    let left = 2u * word >= row.x;
    let right = 2u * word + 1u < row.x + row.width;
    var codes = 0u;
    var mask = 0u;
    if (left) {
        codes = box_value(row, 2u * word - row.x, y);
        mask = 0xffffu;
    }
    if (right) {
        codes |= box_value(row, 2u * word + 1u - row.x, y) << 16u;
        mask |= 0xffff0000u;
    }
    if (left && right) {
        atomicStore(&pictures[at], codes);
    } else {
        atomicAnd(&pictures[at], ~mask);
        atomicOr(&pictures[at], codes);
    }
}
`;var kn=`// Boxes of material (depth.md 4, 5). Mirrors \`impl Texel for [u8; 3]\` of src/codec/depth/texel.rs. An invocation writes a pixel.
// Needs \`box_value\`.

@group(0) @binding(0) var<storage, read> units: array<Unit>;
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> jobs: Jobs;
@group(0) @binding(3) var<storage, read> boxes: array<BoxRow>;
@group(0) @binding(4) var<storage, read> stream: array<u32>;
@group(0) @binding(5) var<storage, read_write> pictures: array<u32>;

// Reads the pixel at column x and row y of a box that is not block-compressed: r | g << 8 | b << 16.
fn stored_value(row: BoxRow, x: u32, y: u32) -> u32 {
    var at = row.at;
    if (row.coding != BOX_CONSTANT) {
        at += 3u * (y * row.width + x);
    }
    return word_at(at) & 0xffffffu;
}

@compute @workgroup_size(WORKGROUP)
fn decode_material(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let found = box_part(invocation);
    let unit = units[found.unit];
    let row = boxes[found.row];
    let x = found.part % row.width;
    let y = found.part / row.width;
    pictures[unit.picture + (row.y + y) * unit.stride + row.x + x] = box_value(row, x, y);
}
`;var En=`// Occupancy of points: BetweenViewpointAndGeometry of algorithm 4 (CALF 6). Mirrors src/march/active_views.rs. Needs \`project\`,
// \`inverse_depth_bits\` and the declarations of marched_views.wgsl.

// Reach in texels of the footprint around a point: all texels that contain a point within this distance decide its occupancy.
const AROUND_REACH: f32 = 0.5 - 1.0 / 64.0;

const EMPTY = 0u;
const OCCUPIED = 1u;
const NOT_KNOWN = 2u;
// Smallest positive normal float.
const MIN_POSITIVE: f32 = 1.17549435e-38;

// The last view that found a point empty; it is tested first.
var<private> empty_view: u32;

fn to_probe(view: u32, direction: vec3<f32>) -> vec3<f32> {
    return views[view].turn_x * direction.x + views[view].turn_y * direction.y + views[view].turn_z * direction.z;
}

fn local_of(view: u32, point: vec3<f32>) -> vec3<f32> {
    return to_probe(view, point - views[view].from_eye);
}

fn nearest_inverse_depth(at: Projected) -> u32 {
    let last = vec2(faces[at.face].width, faces[at.face].height) - 1u;
    return inverse_depth_bits(at.face, min(vec2<u32>(max(at.at, vec2(0.0))), last));
}

// Returns the maximum inverse depth of the texels in a point's footprint.
fn footprint_inverse_depth(at: Projected) -> u32 {
    if (!is_around) {
        return nearest_inverse_depth(at);
    }
    let end = vec2(faces[at.face].width, faces[at.face].height) - 1u;
    let first = min(vec2<u32>(max(at.at - AROUND_REACH, vec2(0.0))), end);
    let last = min(vec2<u32>(max(at.at + AROUND_REACH, vec2(0.0))), end);
    var greatest = inverse_depth_bits(at.face, first);
    if (last.x != first.x) {
        greatest = max(greatest, inverse_depth_bits(at.face, vec2(last.x, first.y)));
    }
    if (last.y != first.y) {
        greatest = max(greatest, inverse_depth_bits(at.face, vec2(first.x, last.y)));
        if (last.x != first.x) {
            greatest = max(greatest, inverse_depth_bits(at.face, last));
        }
    }
    return greatest;
}

fn occupancy(view: u32, point: vec3<f32>) -> u32 {
    let local = local_of(view, point);
    let squared = dot(local, local);
    let near = squared < views[view].near_m * views[view].near_m;
    let at = project(view, local);
    if (at.face == NO_FACE) {
        // The centre of projection itself has no direction.
        return select(NOT_KNOWN, EMPTY, near && squared <= MIN_POSITIVE);
    }
    // Points within near are empty regardless of the texels.
    if (near) {
        return EMPTY;
    }
    let surface = footprint_inverse_depth(at);
    if (surface == UNKNOWN) {
        return NOT_KNOWN;
    }
    return select(OCCUPIED, EMPTY, bitcast<f32>(surface) < at.inverse_depth);
}

// Returns the view to test in this turn: \`empty_view\` is swapped with the first view.
fn view_of_turn(turn: u32) -> u32 {
    return view_at(select(select(turn, 0u, turn == empty_view), empty_view, turn == 0u));
}

fn is_surface(point: vec3<f32>) -> bool {
    var behind = false;
    for (var turn = 0u; turn < view_count(); turn++) {
        let view = view_of_turn(turn);
        let says = occupancy(view, point);
        if (says == EMPTY) {
            remember_empty(view);
            return false;
        }
        behind |= says == OCCUPIED;
    }
    return behind || until_unknown;
}
`;var Sn=`// Counters of rendering. Mirrors src/march/counters.rs.

const PRIMARY_RAYS = 0u;
const MARCH_STEPS = 1u;
const REFINE_STEPS = 2u;
const SECONDARY_RAYS = 3u;
const NORMAL_EVALS = 4u;
const MATERIAL_SAMPLES = 5u;
const HOLE_RAYS = 6u;
const BACKGROUND_RAYS = 7u;
const COUNTERS = 8u;

// Counts of this invocation.
var<private> counted: array<u32, COUNTERS>;
`;var Rn=`// Radiance of a surface without secondary rays. Needs \`light_of\`.

fn surface_light(ray: Ray, distance_m: f32, seen: Seen) -> vec3<f32> {
    return light_of(seen.color);
}
`;var An=`// Interpolates the colour of a point: CalculateColor of algorithm 4 (CALF 6). Mirrors src/march/interpolate.rs. Needs \`project\`
// and \`local_of\`.

const DEPTH_EPSILON: f32 = 0.02;
const HOLE_DIFFERENCE: f32 = 0.1;
const ANGLE_EPSILON: f32 = 0.0005;
const CAMERA_EPSILON: f32 = 0.01;
const EDGE_PENALTY: f32 = 6.0;
const BACKGROUND_EDGE_PENALTY: f32 = 20.0;
const NEARER: f32 = 1.105171;
const DEPTH_CUT: f32 = 0.2;
const CUT_WEIGHT: f32 = 0.001;

// Result of an interpolation over views. \`difference\` is only defined if \`found\`.
struct Seen {
    found: bool,
    // As coded: codes over 255, or linear RGB.
    color: vec3<f32>,
    difference: f32,
    coverage: f32,
    alpha: f32,
}

// The four texels around a position with their bilinear weights, the upper two first.
struct Taps {
    texels: array<vec2<u32>, 4>,
    weights: vec4<f32>,
}

struct Sum {
    color: vec3<f32>,
    weight: f32,
    // Sum of the weights times alpha: the weights of the colours.
    shown: f32,
    difference: f32,
}

const EMPTY_SUM = Sum(vec3(0.0), 0.0, 0.0, 1e30);

fn taps_around(at: vec2<f32>, face: u32) -> Taps {
    let last = vec2(f32(faces[face].width), f32(faces[face].height)) - 1.0;
    let corner = floor(at - 0.5);
    let part = at - 0.5 - corner;
    let first = vec2<u32>(clamp(corner, vec2(0.0), last));
    let second = vec2<u32>(clamp(corner + 1.0, vec2(0.0), last));
    let across = vec2(1.0 - part.x, part.x);
    let down = vec2(1.0 - part.y, part.y);
    return Taps(
        array(first, vec2(second.x, first.y), vec2(first.x, second.y), second),
        vec4(across * down.x, across * down.y),
    );
}

fn seen_of(sum: Sum) -> Seen {
    if (sum.shown > 0.0) {
        return Seen(true, sum.color / sum.shown, sum.difference, 1.0, sum.shown / sum.weight);
    }
    return Seen(sum.weight > 0.0, vec3(0.0), sum.difference, 1.0, 0.0);
}

// Adds a texel to a sum.
fn with_texel(before: Sum, color: vec4<f32>, weight: f32, difference: f32) -> Sum {
    let shown = weight * color.a;
    return Sum(
        before.color + shown * color.rgb,
        before.weight + weight,
        before.shown + shown,
        min(before.difference, difference),
    );
}

// Adds the surface texels around a point in a view to a sum, weighted by the view's share.
fn with_view(before: Sum, view: u32, at: Projected, share: f32) -> Sum {
    var sum = before;
    var taps = taps_around(at.at, at.face);
    for (var tap = 0u; tap < 4u; tap++) {
        let surface = inverse_depth_bits(at.face, taps.texels[tap]);
        if (surface == BACKGROUND || surface == UNKNOWN) {
            continue;
        }
        let difference = abs(log(bitcast<f32>(surface) / at.inverse_depth));
        let weight = share * (taps.weights[tap] * views[view].camera_weight / (difference + DEPTH_EPSILON));
        sum = with_texel(sum, texel_color(at.face, taps.texels[tap]), weight, difference);
    }
    return sum;
}

fn surface_color(point: vec3<f32>) -> Seen {
    var sum = EMPTY_SUM;
    for (var number = 0u; number < view_count(); number++) {
        let view = view_at(number);
        let at = project(view, local_of(view, point));
        if (at.face != NO_FACE) {
            sum = with_view(sum, view, at, 1.0);
        }
    }
    return seen_of(sum);
}

// Returns the weight of a view for a point on a primary ray, from the angle between the eye ray and the view ray, and from
// resolution.
fn angle_weight(view: u32, point: vec3<f32>) -> f32 {
    let from_view = point - views[view].from_eye;
    let from_eye_m = length(point);
    let from_view_m = length(from_view);
    let sine = length(cross(point, from_view)) / max(from_eye_m * from_view_m, MIN_POSITIVE);
    let angle = select(1.0, sine, dot(point, from_view) > 0.0);
    let blur = max(from_view_m / max(from_eye_m, MIN_POSITIVE) - 1.0, 0.0);
    return 1.0 / (angle + blur + ANGLE_EPSILON);
}

// Returns the factor on the weight of a view's texels that are next to a nearer surface; \`epsilon\` is the ε used in \`weight\`.
fn edge_part_of(view: u32, weight: f32, epsilon: f32, penalty: f32) -> f32 {
    if (!is_around || all(views[view].from_eye == vec3(0.0))) {
        return 1.0;
    }
    return 1.0 / (1.0 + penalty - penalty * epsilon * weight);
}

fn is_nearer(face: u32, texel: vec2<u32>, inverse_depth: f32) -> bool {
    let surface = inverse_depth_bits(face, texel);
    return surface != UNKNOWN && bitcast<f32>(surface) > inverse_depth;
}

// True if one of the four adjacent texels shows a surface with a greater inverse depth.
fn is_beside_nearer(face: u32, texel: vec2<u32>, inverse_depth: f32) -> bool {
    return (texel.x > 0u && is_nearer(face, texel - vec2(1u, 0u), inverse_depth))
        || (texel.x + 1u < faces[face].width && is_nearer(face, texel + vec2(1u, 0u), inverse_depth))
        || (texel.y > 0u && is_nearer(face, texel - vec2(0u, 1u), inverse_depth))
        || (texel.y + 1u < faces[face].height && is_nearer(face, texel + vec2(0u, 1u), inverse_depth));
}

fn fit_weight(difference: f32) -> f32 {
    let weight = 1.0 / (difference + DEPTH_EPSILON);
    if ((scene.refinements & REFINE_ANGLES) == 0u) {
        return weight;
    }
    return max(weight - 1.0 / (DEPTH_CUT + DEPTH_EPSILON), CUT_WEIGHT * weight);
}

// Returns the colour, coverage and alpha of a surface point on a primary ray.
fn seen_from_eye(point: vec3<f32>) -> Seen {
    var sum = EMPTY_SUM;
    var opaque = 0.0;
    var covered = 0.0;
    var all = 0.0;
    for (var number = 0u; number < view_count(); number++) {
        let view = view_at(number);
        let at = project(view, local_of(view, point));
        if (at.face == NO_FACE) {
            continue;
        }
        var of_view = views[view].camera_weight;
        var epsilon = CAMERA_EPSILON;
        if ((scene.refinements & REFINE_ANGLES) != 0u) {
            of_view = angle_weight(view, point);
            epsilon = ANGLE_EPSILON;
        }
        let edge_part = edge_part_of(view, of_view, epsilon, EDGE_PENALTY);
        var taps = taps_around(at.at, at.face);
        for (var tap = 0u; tap < 4u; tap++) {
            let surface = inverse_depth_bits(at.face, taps.texels[tap]);
            if (surface == UNKNOWN) {
                continue;
            }
            let weight = taps.weights[tap] * of_view;
            if (surface == BACKGROUND) {
                all += weight;
                continue;
            }
            let nearer = log(bitcast<f32>(surface) / at.inverse_depth);
            let difference = abs(nearer);
            all += select(0.0, weight, nearer <= scene.tolerance);
            let covers = select(0.0, weight, difference <= scene.tolerance);
            covered += covers;
            let color = texel_color(at.face, taps.texels[tap]);
            opaque += covers * color.a;
            let is_edge = edge_part < 1.0
                && is_beside_nearer(at.face, taps.texels[tap], bitcast<f32>(surface) * NEARER);
            let fitting = weight * fit_weight(difference) * select(1.0, edge_part, is_edge);
            sum = with_texel(sum, color, fitting, difference);
        }
    }
    var seen = seen_of(sum);
    if (all > 0.0) {
        seen.coverage = covered / all;
    }
    if (covered > 0.0) {
        seen.alpha = opaque / covered;
    }
    return seen;
}

fn background_color(direction: vec3<f32>) -> Seen {
    var sum = EMPTY_SUM;
    for (var number = 0u; number < view_count(); number++) {
        let view = view_at(number);
        let at = project(view, to_probe(view, direction));
        if (at.face == NO_FACE) {
            continue;
        }
        var taps = taps_around(at.at, at.face);
        let of_view = views[view].camera_weight;
        let edge_part = edge_part_of(view, of_view, CAMERA_EPSILON, BACKGROUND_EDGE_PENALTY);
        for (var tap = 0u; tap < 4u; tap++) {
            if (inverse_depth_bits(at.face, taps.texels[tap]) == BACKGROUND) {
                let is_edge = edge_part < 1.0 && is_beside_nearer(at.face, taps.texels[tap], 0.0);
                let weight = taps.weights[tap] * of_view * select(1.0, edge_part, is_edge);
                sum = with_texel(sum, texel_color(at.face, taps.texels[tap]), weight, 0.0);
            }
        }
    }
    return seen_of(sum);
}
`;var Mn=`// Intersection of a ray with a surface: RayIntersection of algorithm 4 (CALF 6), testing every point. Mirrors
// src/march/intersect.rs. Needs \`is_surface\`.

// Returns the first step at or after \`first\` that is on a surface; \`scene.distance_count\` if there is none.
fn first_step(ray: Ray, first: u32) -> u32 {
    var at = first;
    while (at < scene.distance_count) {
        counted[MARCH_STEPS]++;
        if (is_surface(point_at(ray, distances_m[at]))) {
            break;
        }
        at++;
    }
    return at;
}
`;var Tn=`// Follows a primary ray through successive surfaces, each with its share of the ray, to the background. Mirrors
// src/march/layers.rs. Needs \`first_step\`, \`refined\`, \`seen_from_eye\`, \`background_color\`, \`surface_light\` and \`light_of\`.

const MIN_LAYER: f32 = 1.0 / 64.0;
const MAX_LAYERS = 8u;
const MAX_EXITS = 64u;

// Result of a primary ray. Mirrors src/march/samples.rs.
struct RaySample {
    // Linear RGB times \`share\`.
    light: vec3<f32>,
    // Fraction of the ray that has a colour.
    share: f32,
    // True if the first surface is disoccluded in all views, or the ray ends without a colour.
    is_hole: bool,
}

// State of a ray on its way through layers.
struct Rest {
    light: vec3<f32>,
    left: f32,
    layers: u32,
    // Surfaces nearer than this are skipped.
    least_m: f32,
    // True while the ray is inside a surface with alpha that has been blended.
    is_within: bool,
    // True if the ray has passed a surface with alpha.
    lets_through: bool,
}

struct FirstHits {
    nearest: Hit,
    all: Hit,
}

fn first_hits(ray: Ray) -> FirstHits {
    var hits = FirstHits(Hit(false, 0.0), Hit(false, 0.0));
    var first = 0u;
    if ((scene.refinements & REFINE_THIN) != 0u && scene.view_count > 0u) {
        alone = scene.nearest_view;
        until_unknown = true;
        first = first_step(ray, 0u);
        until_unknown = false;
        if (first < scene.distance_count && is_surface(point_at(ray, distances_m[first]))) {
            hits.nearest = refined(ray, first);
        }
        alone = ALL_VIEWS;
    }
    hits.all = intersect_from(ray, first);
    return hits;
}

// Blends a surface by its coverage and alpha.
fn show(before: Rest, ray: Ray, distance_m: f32, seen: Seen) -> Rest {
    var coverage = 1.0;
    if ((scene.refinements & REFINE_EDGES) != 0u) {
        coverage = seen.coverage;
    }
    let opacity = coverage * seen.alpha;
    var rest = before;
    let has_alpha = seen.alpha <= 1.0 - MIN_LAYER;
    rest.lets_through = rest.lets_through || has_alpha;
    rest.is_within = rest.is_within || (has_alpha && coverage > 1.0 - MIN_LAYER);
    if (opacity < MIN_LAYER) {
        return rest;
    }
    var left = before.left * (1.0 - opacity);
    if (before.layers + 1u == MAX_LAYERS || opacity > 1.0 - MIN_LAYER || left < MIN_LAYER) {
        left = 0.0;
    }
    is_around = false;
    let light = surface_light(ray, distance_m, seen);
    is_around = (scene.refinements & REFINE_EDGES) != 0u;
    rest.light += (before.left - left) * light;
    rest.left = left;
    rest.layers++;
    rest.least_m = distance_m * exp(HOLE_DIFFERENCE);
    return rest;
}

// Ends a ray whose remaining share has no colour.
fn end_in_hole(rest: Rest, unseen: Seen) -> RaySample {
    if (rest.layers == 0u) {
        let share = select(0.0, 1.0, unseen.found);
        return RaySample(share * light_of(unseen.color), share, true);
    }
    return RaySample(rest.light / (1.0 - rest.left), 1.0, false);
}

fn follow(ray: Ray) -> RaySample {
    let hits = first_hits(ray);
    let cosine = max(dot(ray.direction, scene.forward), MIN_POSITIVE);
    let near_m = scene.near_m / cosine;
    var rest = Rest(vec3(0.0), 1.0, 0u, near_m, false, false);
    var unseen = Seen(false, vec3(0.0), 0.0, 1.0, 1.0);
    var is_hole = false;
    let thin_m = hits.nearest.distance_m;
    if (hits.nearest.found && thin_m >= near_m && thin_m * cosine <= scene.far_m
        && (!hits.all.found || thin_m < hits.all.distance_m * exp(-HOLE_DIFFERENCE))) {
        let seen = seen_from_eye(point_at(ray, thin_m));
        if (seen.found && seen.difference <= scene.tolerance) {
            rest = show(rest, ray, thin_m, seen);
        }
    }
    var hit = hits.all;
    for (var exits = 0u; exits < MAX_EXITS; exits++) {
        if (!hit.found || hit.distance_m * cosine > scene.far_m || rest.left == 0.0) {
            break;
        }
        var at_m = hit.distance_m;
        var within = scene.tolerance;
        var is_inside = false;
        // A surface that begins before the near plane is clipped, including its inside.
        let is_cut = at_m < near_m;
        rest.is_within = rest.is_within && at_m < rest.least_m;
        // Finds the first step behind the hit.
        var next = 0u;
        var above = scene.distance_count;
        while (next < above) {
            let half = (next + above) / 2u;
            if (distances_m[half] <= at_m) {
                next = half + 1u;
            } else {
                above = half;
            }
        }
        loop {
            if (at_m >= rest.least_m && !is_cut && !rest.is_within) {
                let seen = seen_from_eye(point_at(ray, at_m));
                if (seen.found && seen.difference <= within) {
                    rest = show(rest, ray, at_m, seen);
                } else {
                    if (seen.found) {
                        unseen = seen;
                    }
                    if (rest.layers == 0u && !is_inside) {
                        is_hole = true;
                        if (scene.holes != HOLES_BEHIND) {
                            return end_in_hole(rest, unseen);
                        }
                    }
                }
                if (rest.left == 0.0) {
                    return RaySample(rest.light, 1.0, is_hole);
                }
            }
            within = HOLE_DIFFERENCE + scene.log_step;
            is_inside = true;
            if (next >= scene.distance_count || distances_m[min(next, scene.distance_count - 1u)] * cosine > scene.far_m) {
                hit.found = false;
                break;
            }
            counted[MARCH_STEPS]++;
            at_m = distances_m[next];
            if (!is_surface(point_at(ray, at_m))) {
                hit = intersect_from(ray, next);
                break;
            }
            next++;
        }
    }
    if (rest.left == 0.0) {
        return RaySample(rest.light, 1.0, is_hole);
    }
    if (rest.layers == 0u) {
        counted[BACKGROUND_RAYS]++;
    }
    let seen = background_color(ray.direction);
    if (scene.background == BACKGROUND_TRANSPARENT && (seen.found || rest.lets_through)) {
        return RaySample(rest.light, 1.0 - rest.left, is_hole);
    }
    if (seen.found) {
        let share = rest.left * seen.alpha;
        return RaySample(rest.light + share * light_of(seen.color), 1.0 - (rest.left - share), is_hole);
    }
    let ended = end_in_hole(rest, unseen);
    return RaySample(ended.light, ended.share, ended.is_hole || is_hole);
}
`;var Cn=`// Input of a picture, written by src/gpu/render/scene.rs; a test compares the two.

struct Scene {
    // Camera axes: forward has length 1; right and down reach the edges of the picture at distance 1.
    forward: vec3<f32>,
    width: u32,
    right: vec3<f32>,
    height: u32,
    down: vec3<f32>,
    // First row of this dispatch.
    first_row: u32,
    // Number of rays in each row and column of a pixel.
    samples: u32,
    view_count: u32,
    distance_count: u32,
    refine: u32,
    // A hit with a greater depth difference is disoccluded.
    tolerance: f32,
    // Rendering of disoccluded surfaces: HOLES_BLANK, HOLES_NEAREST or HOLES_BEHIND.
    holes: u32,
    coding: u32,
    // Linear value of the brightest code.
    gain: f32,
    max_bounces: u32,
    // Number of rows of this dispatch.
    rows: u32,
    // Height of an image's pyramid in texels: the image height rounded up to a power of two.
    pyramid_rows: u32,
    // Maximum number of points in a segment, a power of two; 1 if every point is tested.
    longest_segment: u32,
    // Number of points in the first segment.
    first_segment: u32,
    // Number of proxies; their environment maps follow the active views in \`views\`.
    proxy_count: u32,
    // Clip planes of the camera: metres along its axis.
    near_m: f32,
    far_m: f32,
    // Centre of the picture in multiples of \`right\` and \`down\`; 0 unless the window is off-axis.
    middle: vec2<f32>,
    // Logarithm of the ratio of adjacent distances.
    log_step: f32,
    // Index of the view nearest to the eye.
    nearest_view: u32,
    // Set of REFINE_ANGLES, REFINE_EDGES and REFINE_THIN.
    refinements: u32,
    // Rendering of the background: BACKGROUND_OPAQUE or BACKGROUND_TRANSPARENT.
    background: u32,
    spare: vec2<f32>,
}

struct View {
    // Vector from the eye to the view in metres, in world axes.
    from_eye: vec3<f32>,
    // Near distance in metres; for an environment map, the radius of the proxy.
    near_m: f32,
    // Columns of the matrix that rotates world directions to probe axes.
    turn_x: vec3<f32>,
    camera_weight: f32,
    turn_y: vec3<f32>,
    // Upper bound of the inverse depths of all texels.
    greatest_inverse_depth: f32,
    turn_z: vec3<f32>,
    // Environment maps only: maximum distance of a point from the proxy's surface, in metres.
    reach_m: f32,
    // Rows of \`faces\`, or NO_FACE.
    faces: array<u32, 8>,
}

struct Face {
    // Position of its first texel in the textures, and the layer.
    column: u32,
    row: u32,
    layer: u32,
    has_material: u32,
    width: u32,
    height: u32,
    // Position of its pyramid, in the same layer of the pyramid texture, and the number of levels; 0 if it has no pyramid.
    pyramid_column: u32,
    pyramid_row: u32,
    levels: u32,
    // Index of the cube face, or VIEW_FACE.
    number: u32,
    scale: vec2<f32>,
    centre: vec2<f32>,
    // 1 if the fourth component of its colours is alpha; 0 if it is opaque.
    has_alpha: u32,
    spare: u32,
}

// The view has no such image.
const NO_FACE = 0xffffffffu;
// Index of the image of a perspective probe.
const VIEW_FACE = 6u;
// Coding of colours: linear RGB, sRGB codes, or linear codes.
const CODING_LIGHT = 0u;
const CODING_SRGB = 1u;
const CODING_LINEAR = 2u;

const HOLES_BLANK = 0u;
const HOLES_NEAREST = 1u;
const HOLES_BEHIND = 2u;
const BACKGROUND_OPAQUE = 0u;
const BACKGROUND_TRANSPARENT = 1u;
// Bit flags of \`refinements\`.
const REFINE_ANGLES = 1u;
const REFINE_EDGES = 2u;
const REFINE_THIN = 4u;

@group(0) @binding(0) var<storage, read> scene: Scene;
@group(0) @binding(1) var<storage, read> views: array<View>;
@group(0) @binding(2) var<storage, read> faces: array<Face>;
`;var On=`// Texels, and the projection of points into the images of a view (CALF 6). Mirrors \`View::project\` of src/views/light_field.rs
// over src/codec/image/texel_map.rs; tests/gpu/projection.rs compares the two.
//
// Inverse depths are read as the bits of floats: +inf marks unknown texels, and shaders may assume that no float is infinite.

@group(0) @binding(4) var inverse_depths: texture_2d_array<u32>;
@group(0) @binding(5) var colors: texture_2d_array<f32>;

const BACKGROUND = 0u;
const UNKNOWN = 0x7f800000u;
// The inverse of a smaller length is not representable on every device.
const MIN_INVERTIBLE_M: f32 = 1e-37;

// Position of a point in an image; \`face\` is a row of \`faces\`, or NO_FACE.
struct Projected {
    face: u32,
    at: vec2<f32>,
    inverse_depth: f32,
}

// Index of the cube face, (u, v) at distance 1 before the division by depth, and planar depth of a point.
struct CubePlace {
    face: u32,
    plane: vec2<f32>,
    planar_m: f32,
}

fn cube_face(x: vec3<f32>) -> CubePlace {
    let size = abs(x);
    if (size.x >= size.y && size.x >= size.z) {
        let negative = x.x < 0.0;
        return CubePlace(select(0u, 1u, negative), vec2(select(-x.z, x.z, negative), -x.y), size.x);
    }
    if (size.y >= size.z) {
        let negative = x.y < 0.0;
        return CubePlace(select(2u, 3u, negative), vec2(x.x, select(x.z, -x.z, negative)), size.y);
    }
    let negative = x.z < 0.0;
    return CubePlace(select(4u, 5u, negative), vec2(select(x.x, -x.x, negative), -x.y), size.z);
}

const NOWHERE = Projected(NO_FACE, vec2(0.0), 0.0);

fn project_to_view(from_probe: vec3<f32>, face: u32) -> Projected {
    if (-from_probe.z < MIN_INVERTIBLE_M) {
        return NOWHERE;
    }
    let inverse_depth = 1.0 / -from_probe.z;
    let plane = vec2(from_probe.x * inverse_depth, -from_probe.y * inverse_depth);
    let at = plane * faces[face].scale + faces[face].centre;
    let size = vec2(f32(faces[face].width), f32(faces[face].height));
    if (all(at >= vec2(0.0)) && all(at < size)) {
        return Projected(face, at, inverse_depth);
    }
    return NOWHERE;
}

fn project(view: u32, from_probe: vec3<f32>) -> Projected {
    let single = views[view].faces[VIEW_FACE];
    if (single != NO_FACE) {
        return project_to_view(from_probe, single);
    }
    let place = cube_face(from_probe);
    let face = views[view].faces[place.face];
    if (face == NO_FACE || place.planar_m < MIN_INVERTIBLE_M) {
        return NOWHERE;
    }
    let scale = 1.0 / place.planar_m;
    let at = place.plane * scale * faces[face].scale + faces[face].centre;
    return Projected(face, at, scale);
}

// Returns the bits of a texel's inverse planar depth.
fn inverse_depth_bits(face: u32, texel: vec2<u32>) -> u32 {
    let place = vec2(faces[face].column, faces[face].row) + texel;
    return textureLoad(inverse_depths, place, faces[face].layer, 0).r;
}

// Returns the colour of a texel, as codes over 255 or linear RGB, and its alpha.
fn texel_color(face: u32, texel: vec2<u32>) -> vec4<f32> {
    let place = vec2(faces[face].column, faces[face].row) + texel;
    let color = textureLoad(colors, place, faces[face].layer, 0);
    return vec4(color.rgb, select(1.0, color.a, faces[face].has_alpha != 0u));
}
`;var Pn=`// Selects the views that are marched: all active views, or a single one (the nearest, or the environment map of a proxy).

const ALL_VIEWS = 0xffffffffu;

// Index of the single view, or ALL_VIEWS.
var<private> alone: u32 = ALL_VIEWS;
// True for primary rays: a point's occupancy is decided by the texels around it rather than the one that contains it.
var<private> is_around: bool = false;
// True if marching also ends at a point that is empty in no view but occupied in none either.
var<private> until_unknown: bool = false;

fn view_count() -> u32 {
    return select(1u, scene.view_count, alone == ALL_VIEWS);
}

fn view_at(number: u32) -> u32 {
    return select(alone, number, alone == ALL_VIEWS);
}

fn remember_empty(view: u32) {
    empty_view = select(empty_view, view, alone == ALL_VIEWS);
}
`;var Nn=`// Interpolates the material of a surface point: SampleMaterial of algorithm 4 (CALF 6.1). Mirrors
// src/march/specular/material.rs. Needs \`project\`, \`local_of\`, \`taps_around\` and \`DEPTH_EPSILON\`.

@group(0) @binding(9) var materials: texture_2d_array<f32>;

const MIN_WEIGHT: f32 = 0.5 / 255.0;
const CLEAR: f32 = 0.95;
// Range of refractive indices that an 8-bit code represents.
const MIN_IOR: f32 = 1.0;
const GREATEST_IOR: f32 = 3.0;

struct Material {
    found: bool,
    reflect: f32,
    refract: f32,
    ior: f32,
}

const NO_MATERIAL = Material(false, 0.0, 0.0, MIN_IOR);

// Returns the weights of reflection and refraction and the refractive index, as codes over 255.
fn texel_material(face: u32, texel: vec2<u32>) -> vec3<f32> {
    let place = vec2(faces[face].column, faces[face].row) + texel;
    return textureLoad(materials, place, faces[face].layer, 0).rgb;
}

fn surface_material(point: vec3<f32>) -> Material {
    // Weighted sums of reflection, refraction, index times refraction, and the sum of the weights.
    var sum = vec4(0.0);
    for (var view = 0u; view < scene.view_count; view++) {
        let at = project(view, local_of(view, point));
        if (at.face == NO_FACE || faces[at.face].has_material == 0u) {
            continue;
        }
        var taps = taps_around(at.at, at.face);
        for (var tap = 0u; tap < 4u; tap++) {
            let surface = inverse_depth_bits(at.face, taps.texels[tap]);
            if (surface == BACKGROUND || surface == UNKNOWN) {
                continue;
            }
            let difference = abs(log(bitcast<f32>(surface) / at.inverse_depth));
            let weight = taps.weights[tap] * views[view].camera_weight / (difference + DEPTH_EPSILON);
            let coded = texel_material(at.face, taps.texels[tap]);
            sum += weight * vec4(coded.x, coded.y, coded.y * coded.z, 1.0);
        }
    }
    if (!(sum.x + sum.y > MIN_WEIGHT * sum.w)) {
        return NO_MATERIAL;
    }
    var ior = MIN_IOR;
    if (sum.y > 0.0) {
        ior += sum.z / sum.y * (GREATEST_IOR - MIN_IOR);
    }
    let whole = max(sum.w, sum.x + sum.y);
    return Material(true, sum.x / whole, sum.y / whole, ior);
}

fn fresnel(direct: f32, ior: f32) -> f32 {
    let cosine = clamp(direct, 0.0, 1.0);
    let inside = sqrt(max(1.0 - (1.0 - cosine * cosine) / (ior * ior), 0.0));
    let sums = vec2(cosine + ior * inside, ior * cosine + inside);
    // At grazing incidence with an index of 1 nothing is reflected.
    if (min(sums.x, sums.y) <= 0.0) {
        return 0.0;
    }
    let parts = vec2(cosine - ior * inside, ior * cosine - inside) / sums;
    return min(0.5 * dot(parts, parts), 1.0);
}

fn at_angle(material: Material, cosine: f32) -> Material {
    let whole = material.reflect + material.refract;
    if (material.refract == 0.0 || whole < CLEAR) {
        return material;
    }
    let reflected = whole * fresnel(cosine, material.ior);
    return Material(true, reflected, whole - reflected, material.ior);
}
`;var Fn=`// Estimates the normal and curvature of a surface point from the depths around it (CALF 6.1). Mirrors
// src/march/specular/normal.rs. Needs \`project\`, \`local_of\`, \`texel_material\` and \`DEPTH_EPSILON\`.

const SAME_SURFACE: f32 = 0.02;
const MAX_REACH: i32 = 2;
const FIT: f32 = 0.01;
const SAME_PATCH: f32 = 0.03;
const SAME_MATERIAL: i32 = 64;
// The texel has no inverse depth on this surface.
const NO_TEXEL: f32 = -1.0;
// A shorter vector has no direction.
const MIN_LENGTH: f32 = 1e-30;

// \`curvature\` is only defined if \`bends\`.
struct Patch {
    found: bool,
    bends: bool,
    normal: vec3<f32>,
    curvature: f32,
    texel_m: f32,
}

const NO_PATCH = Patch(false, false, vec3(0.0), 0.0, 0.0);

struct Axes {
    forward: vec3<f32>,
    right: vec3<f32>,
    down: vec3<f32>,
}

// Inverse depth around the centre of a texel: c[0] + c[1]x + c[2]y + c[3]x² + c[4]xy + c[5]y².
struct Fit {
    found: bool,
    bends: bool,
    c: array<f32, 6>,
}

// Neighbourhood of a texel; \`solid\` is -1 if there is no material.
struct Around {
    face: u32,
    texel: vec2<u32>,
    solid: i32,
}

// Surface patch in one view, in the view's axes.
struct LocalPatch {
    found: bool,
    bends: bool,
    normal: vec3<f32>,
    curvature: f32,
    texel_m: f32,
    difference: f32,
    facing: f32,
}

fn face_axes(number: u32) -> Axes {
    switch number {
        case 0u: {
            return Axes(vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, -1.0), vec3(0.0, -1.0, 0.0));
        }
        case 1u: {
            return Axes(vec3(-1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), vec3(0.0, -1.0, 0.0));
        }
        case 2u: {
            return Axes(vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0));
        }
        case 3u: {
            return Axes(vec3(0.0, -1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, -1.0));
        }
        case 4u: {
            return Axes(vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0));
        }
        case 5u: {
            return Axes(vec3(0.0, 0.0, -1.0), vec3(-1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0));
        }
        default: {
            return Axes(vec3(0.0, 0.0, -1.0), vec3(1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0));
        }
    }
}

fn solid_of(face: u32, texel: vec2<u32>) -> i32 {
    if (faces[face].has_material == 0u) {
        return -1;
    }
    let weights = round(texel_material(face, texel).xy * 255.0);
    return i32(weights.x) + i32(weights.y);
}

// Returns the inverse depth of a neighbour that may belong to the same surface, or NO_TEXEL.
fn texel_around(around: Around, x: i32, y: i32) -> f32 {
    let place = vec2<i32>(around.texel) + vec2(x, y);
    if (any(place < vec2(0)) || place.x >= i32(faces[around.face].width) || place.y >= i32(faces[around.face].height)) {
        return NO_TEXEL;
    }
    let texel = vec2<u32>(place);
    let bits = inverse_depth_bits(around.face, texel);
    if (bits == BACKGROUND || bits == UNKNOWN) {
        return NO_TEXEL;
    }
    if (around.solid >= 0 && abs(solid_of(around.face, texel) - around.solid) > SAME_MATERIAL) {
        return NO_TEXEL;
    }
    return bitcast<f32>(bits);
}

fn fit_value(fit: Fit, at: vec2<f32>) -> f32 {
    let c = fit.c;
    return c[0] + c[1] * at.x + c[2] * at.y + c[3] * at.x * at.x + c[4] * at.x * at.y + c[5] * at.y * at.y;
}

fn fit_slope(fit: Fit, at: vec2<f32>) -> vec2<f32> {
    let c = fit.c;
    return vec2(c[1] + 2.0 * c[3] * at.x + c[4] * at.y, c[2] + c[4] * at.x + 2.0 * c[5] * at.y);
}

const NO_FIT = Fit(false, false, array(0.0, 0.0, 0.0, 0.0, 0.0, 0.0));

// Fits a quadratic polynomial by least squares to a complete square of texels.
fn bent(around: Around, reach: i32) -> Fit {
    let side = f32(2 * reach + 1);
    // Sums of x² and of (x² − mean)² over a row.
    var squares = 0.0;
    for (var column = -reach; column <= reach; column++) {
        squares += f32(column * column);
    }
    let mean_square = squares / side;
    var fourths = 0.0;
    for (var column = -reach; column <= reach; column++) {
        let off = f32(column * column) - mean_square;
        fourths += off * off;
    }
    var sums = array(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (var row = -reach; row <= reach; row++) {
        for (var column = -reach; column <= reach; column++) {
            let inverse = texel_around(around, column, row);
            if (inverse < 0.0) {
                return NO_FIT;
            }
            let x = f32(column);
            let y = f32(row);
            sums[0] += inverse;
            sums[1] += x * inverse;
            sums[2] += y * inverse;
            sums[3] += (x * x - mean_square) * inverse;
            sums[4] += x * y * inverse;
            sums[5] += (y * y - mean_square) * inverse;
        }
    }
    var c = array(
        sums[0] / (side * side),
        sums[1] / (side * squares),
        sums[2] / (side * squares),
        sums[3] / (side * fourths),
        sums[4] / (squares * squares),
        sums[5] / (side * fourths),
    );
    c[0] -= mean_square * (c[3] + c[5]);
    let fit = Fit(true, true, c);
    let far = FIT * c[0];
    for (var row = -reach; row <= reach; row++) {
        for (var column = -reach; column <= reach; column++) {
            let value = fit_value(fit, vec2(f32(column), f32(row)));
            if (!(abs(texel_around(around, column, row) - value) <= far)) {
                return NO_FIT;
            }
        }
    }
    return fit;
}

// Fits a plane through the centre of 3 x 3 texels to those with a similar inverse depth.
fn flat_fit(around: Around) -> Fit {
    let middle = texel_around(around, 0, 0);
    var squares = vec3(0.0);
    var differences = vec2(0.0);
    for (var row = -1; row <= 1; row++) {
        for (var column = -1; column <= 1; column++) {
            let other = texel_around(around, column, row);
            if (other < 0.0 || abs(other - middle) > SAME_PATCH * middle) {
                continue;
            }
            let x = f32(column);
            let y = f32(row);
            squares += vec3(x * x, x * y, y * y);
            differences += vec2(x, y) * (other - middle);
        }
    }
    let determinant = squares.x * squares.z - squares.y * squares.y;
    if (determinant < 0.5) {
        return NO_FIT;
    }
    let x = (differences.x * squares.z - differences.y * squares.y) / determinant;
    let y = (differences.y * squares.x - differences.x * squares.y) / determinant;
    return Fit(true, false, array(middle, x, y, 0.0, 0.0, 0.0));
}

fn fit_around(face: u32, texel: vec2<u32>) -> Fit {
    let around = Around(face, texel, solid_of(face, texel));
    if (texel_around(around, 0, 0) < 0.0) {
        return NO_FIT;
    }
    for (var reach = MAX_REACH; reach >= 1; reach--) {
        let fit = bent(around, reach);
        if (fit.found) {
            return fit;
        }
    }
    return flat_fit(around);
}

// Returns the coordinates at distance 1 of an offset in texels from the centre of a texel.
fn plane_at(face: u32, texel: vec2<u32>, offset: vec2<f32>) -> vec2<f32> {
    return (vec2<f32>(texel) + 0.5 + offset - faces[face].centre) / faces[face].scale;
}

// Returns the unit normal of a fit; 0 if it is degenerate.
fn fit_normal(fit: Fit, face: u32, texel: vec2<u32>, offset: vec2<f32>) -> vec3<f32> {
    let plane = plane_at(face, texel, offset);
    let by = fit_slope(fit, offset) * faces[face].scale;
    let ahead = fit_value(fit, offset) - dot(by, plane);
    let axes = face_axes(faces[face].number);
    let normal = -(by.x * axes.right + by.y * axes.down + ahead * axes.forward);
    let size = length(normal);
    return select(vec3(0.0), normal / max(size, MIN_LENGTH), size > MIN_LENGTH);
}

fn fit_point(fit: Fit, face: u32, texel: vec2<u32>, offset: vec2<f32>) -> vec3<f32> {
    let plane = plane_at(face, texel, offset);
    let axes = face_axes(faces[face].number);
    let value = fit_value(fit, offset);
    return (axes.forward + plane.x * axes.right + plane.y * axes.down) / select(value, MIN_LENGTH, abs(value) < MIN_LENGTH);
}

fn patch_of_view(view: u32, local: vec3<f32>) -> LocalPatch {
    let none = LocalPatch(false, false, vec3(0.0), 0.0, 0.0, 0.0, 0.0);
    let at = project(view, local);
    if (at.face == NO_FACE) {
        return none;
    }
    let last = vec2(faces[at.face].width, faces[at.face].height) - 1u;
    let texel = min(vec2<u32>(max(at.at, vec2(0.0))), last);
    let offset = at.at - (vec2<f32>(texel) + 0.5);
    let fit = fit_around(at.face, texel);
    if (!fit.found) {
        return none;
    }
    let value = fit_value(fit, offset);
    // A fit may be negative away from the texel centre.
    let difference = select(1e30, abs(log(max(value, MIN_LENGTH) / at.inverse_depth)), value > 0.0);
    if (!(difference <= SAME_SURFACE)) {
        return none;
    }
    let normal = fit_normal(fit, at.face, texel, offset);
    let facing = -dot(normal, local / max(length(local), MIN_LENGTH));
    if (!(facing > 0.0)) {
        return none;
    }
    var turned = 0.0;
    var moved = 0.0;
    var bends = fit.bends;
    for (var axis = 0u; axis < 2u; axis++) {
        let step = select(vec2(0.0, 1.0), vec2(1.0, 0.0), axis == 0u);
        let a = fit_normal(fit, at.face, texel, -step);
        let b = fit_normal(fit, at.face, texel, step);
        bends = bends && any(a != vec3(0.0)) && any(b != vec3(0.0));
        let along = fit_point(fit, at.face, texel, step) - fit_point(fit, at.face, texel, -step);
        turned += dot(along, b - a);
        moved += dot(along, along);
    }
    bends = bends && moved > MIN_LENGTH;
    let texel_m = 1.0 / (at.inverse_depth * min(abs(faces[at.face].scale.x), abs(faces[at.face].scale.y)));
    return LocalPatch(true, bends, normal, turned / max(moved, MIN_LENGTH), texel_m, difference, facing);
}

// Rotates a direction from probe axes to world axes.
fn from_probe(view: u32, direction: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(views[view].turn_x, direction),
        dot(views[view].turn_y, direction),
        dot(views[view].turn_z, direction),
    );
}

fn patch_at(point: vec3<f32>) -> Patch {
    var normal = vec3(0.0);
    var curvature = 0.0;
    var bent_weight = 0.0;
    var best_weight = 0.0;
    var texel_m = 0.0;
    for (var view = 0u; view < scene.view_count; view++) {
        let seen = patch_of_view(view, local_of(view, point));
        if (!seen.found) {
            continue;
        }
        let weight = views[view].camera_weight * seen.facing / (seen.difference + DEPTH_EPSILON);
        normal += weight * from_probe(view, seen.normal);
        if (seen.bends) {
            curvature += weight * seen.curvature;
            bent_weight += weight;
        }
        if (weight > best_weight) {
            best_weight = weight;
            texel_m = seen.texel_m;
        }
    }
    let size = length(normal);
    if (size <= MIN_LENGTH) {
        return NO_PATCH;
    }
    let bends = bent_weight > 0.0;
    return Patch(true, bends, normal / size, curvature / select(1.0, bent_weight, bends), texel_m);
}
`;var Un=`// Computes the maximum inverse depths of squares of texels, one pyramid level per dispatch: \`DepthPyramid::update\` of
// src/march/pyramid.rs. An invocation writes one square. Inverse depths are never negative, so their bits compare as integers.
// Needs \`job_of\`.

@group(0) @binding(0) var<storage, read> jobs: PyramidJobs;
@group(0) @binding(1) var<storage, read_write> planes: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn write_squares(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let square = invocation - job_begin(number);
    let at = vec2u(job.left + square % job.width, job.top + square / job.width);
    let last = vec2u(job.below_width, job.below_height) - 1u;
    var greatest = 0u;
    for (var corner = 0u; corner < 4u; corner++) {
        let below = min(2u * at + vec2u(corner % 2u, corner / 2u), last);
        greatest = max(greatest, planes[job.below + below.y * job.below_pitch + below.x]);
    }
    planes[job.output + at.y * job.pitch + at.x] = min(greatest, job.limit);
}
`;var Ln=`// Rays, in metres from the eye, and the distances of their samples. Mirrors src/march/ray.rs.

@group(0) @binding(3) var<storage, read> distances_m: array<f32>;

struct Ray {
    origin: vec3<f32>,
    // Unit vector.
    direction: vec3<f32>,
}

// First intersection of a ray with a surface, if any.
struct Hit {
    found: bool,
    distance_m: f32,
}

fn point_at(ray: Ray, distance_m: f32) -> vec3<f32> {
    return ray.origin + ray.direction * distance_m;
}

const GROWTH: f32 = 0.125;
const MAX_BEFORE_STEPS = 64u;

// Next distance of a ray that starts on a surface; if it is a step, its index follows from \`step\`.
struct FromSurface {
    distance_m: f32,
    // Index of the next step.
    step: u32,
    is_step: bool,
    // Number of distances before the first step.
    before: u32,
}

const IN_SURFACE = FromSurface(0.0, 0u, false, 0u);

// \`Steps::off_surface\`: texel-sized intervals before the first step, then the steps. Requires that a step remains.
fn next_from_surface(last: FromSurface, texel_m: f32) -> FromSurface {
    let next_m = last.distance_m + max(texel_m, GROWTH * last.distance_m);
    if (!last.is_step && last.before < MAX_BEFORE_STEPS && next_m < distances_m[0]) {
        return FromSurface(next_m, 0u, false, last.before + 1u);
    }
    return FromSurface(distances_m[last.step], last.step + 1u, true, last.before);
}

// Returns the first hit of a ray at or after step \`first\`; nearer points count as empty. Needs \`first_step\`.
fn intersect_from(ray: Ray, first: u32) -> Hit {
    return refined(ray, first_step(ray, first));
}

// Returns the refined hit in the interval that ends at a step; none if \`step\` is past the last one.
fn refined(ray: Ray, step: u32) -> Hit {
    if (step >= scene.distance_count) {
        return Hit(false, 0.0);
    }
    let before_m = select(0.0, distances_m[max(step, 1u) - 1u], step > 0u);
    return Hit(true, refine(ray, before_m, distances_m[step], scene.refine));
}

// Bisects the interval in which a surface begins; returns the end of the interval that is on the surface. Needs \`is_surface\`.
fn refine(ray: Ray, from_m: f32, to_m: f32, times: u32) -> f32 {
    var empty_m = from_m;
    var surface_m = to_m;
    for (var turn = 0u; turn < times; turn++) {
        let middle_m = 0.5 * (empty_m + surface_m);
        counted[REFINE_STEPS]++;
        if (is_surface(point_at(ray, middle_m))) {
            surface_m = middle_m;
        } else {
            empty_m = middle_m;
        }
    }
    return surface_m;
}
`;var In=`// Renders from any eye: Main of algorithm 4 (CALF 6). Mirrors src/march/render.rs.
//
// An invocation renders a pixel. Counters are summed over a workgroup. Needs \`follow\`.

@group(0) @binding(6) var<storage, read_write> pixels: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> counts: array<u32>;

// Width and height of a workgroup in pixels.
const TILE = 8u;

var<workgroup> group_counts: array<atomic<u32>, COUNTERS>;

// Alpha of a pixel whose loops were terminated by the device.
const GIVEN_UP: f32 = -1.0;
const EDGE_CONTRAST: f32 = 0.1;
const EDGE_BLACK: f32 = 0.02;

// True if a ray of a pixel belongs to the first pass: the corners and the centre of the grid; all rays of a grid of at most two
// rows. Mirrors src/march/samples.rs.
fn is_first(place: vec2<u32>) -> bool {
    let last = scene.samples - 1u;
    let is_corner = (place.x == 0u || place.x == last) && (place.y == 0u || place.y == last);
    return scene.samples <= 2u || is_corner || all(place == vec2(scene.samples / 2u));
}

fn render_pixel(x: u32, y: u32) -> vec4<f32> {
    // Sum, minimum and maximum of RGB and alpha.
    var sum = vec4(0.0);
    var least = vec4(1e30);
    var greatest = vec4(-1e30);
    var share = 0.0;
    var rays = 0u;
    let samples = scene.samples;
    let count = samples * samples;
    for (var turn = 0u; turn < 2u * count; turn++) {
        let place = vec2(turn % count % samples, turn % count / samples);
        if (turn == count && !any(greatest - least > EDGE_CONTRAST * (least + greatest + 2.0 * EDGE_BLACK))) {
            // The first rays show no edge.
            break;
        }
        if (is_first(place) != (turn < count)) {
            continue;
        }
        let sample = (vec2<f32>(place) + 0.5) / f32(samples);
        let window = 2.0 * (vec2(f32(x), f32(y)) + sample) / vec2(f32(scene.width), f32(scene.height)) - 1.0;
        let plane = window + scene.middle;
        let direction = normalize(scene.forward + plane.x * scene.right + plane.y * scene.down);
        counted[PRIMARY_RAYS]++;
        is_around = (scene.refinements & REFINE_EDGES) != 0u;
        var found = follow(Ray(vec3(0.0), direction));
        if (found.is_hole && scene.holes == HOLES_BLANK) {
            found = RaySample(vec3(0.0), 0.0, true);
        }
        counted[HOLE_RAYS] += select(0u, 1u, found.is_hole);
        let alpha = select(found.share, 0.0, found.is_hole && scene.holes != HOLES_BEHIND);
        let shown = vec4(found.light, alpha);
        sum += shown;
        least = min(least, shown);
        greatest = max(greatest, shown);
        share += found.share;
        rays++;
    }
    return vec4(select(vec3(0.0), sum.rgb / share, share > 0.0), sum.a / f32(rays));
}

@compute @workgroup_size(TILE, TILE)
fn render(
    @builtin(local_invocation_index) local: u32,
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let y = scene.first_row + id.y;
    if (id.x < scene.width && id.y < scene.rows) {
        let pixel = render_pixel(id.x, y);
        // Detects devices that terminate long loops, as software devices do: they terminate this loop too.
        var turns = 0u;
        while (turns < scene.samples) {
            turns++;
        }
        pixels[y * scene.width + id.x] = select(vec4(GIVEN_UP), pixel, turns == scene.samples);
    }
    for (var at = 0u; at < COUNTERS; at++) {
        atomicAdd(&group_counts[at], counted[at]);
    }
    workgroupBarrier();
    if (local < COUNTERS) {
        let row = scene.first_row / TILE + group.y;
        counts[(row * groups.x + group.x) * COUNTERS + local] = atomicLoad(&group_counts[local]);
    }
}
`;var Bn=`// Secondary rays of reflective and refractive surfaces: CalculateColor_RR of algorithm 4 (CALF 6.1). Mirrors
// src/march/specular/secondary_rays.rs.
//
// Replaces diffuse.wgsl. WGSL has no recursion, so surfaces that are still to be shaded are kept on a stack. Needs
// \`surface_material\`, \`patch_at\`, \`pass_through\`, \`intersect_from\`, \`surface_color\`, \`with_view\`, \`background_color\`,
// \`light_of\`, and the declarations of active_views.wgsl.

const MIN_SHARE: f32 = 1.0 / 256.0;
const LIFT_TEXELS: f32 = 1.0;
const HIDDEN_TEXELS: f32 = 12.0;
const RECORDED_SINE: f32 = 0.05;
const SETTLE_TIMES = 8u;
// Capacity of the stack. A surface has at most four secondary rays, so eight bounces need at most 25 entries.
const MAX_PENDING = 32u;

// A surface hit that is still to be shaded; \`light\` is linear RGB.
struct Pending {
    point: vec3<f32>,
    direction: vec3<f32>,
    light: vec3<f32>,
    share: f32,
    bounces: u32,
}

struct Recorded {
    share: f32,
    light: vec3<f32>,
}

const FOUND_NOTHING = 0u;
// Radiance that needs no further rays.
const FOUND_LIGHT = 1u;
const FOUND_SURFACE = 2u;

struct Found {
    kind: u32,
    point: vec3<f32>,
    light: vec3<f32>,
}

var<private> pending: array<Pending, MAX_PENDING>;
var<private> pending_count: u32;

// Result of leaving the surface at a ray's origin: a hit on another surface, or empty space at step \`first\`.
struct Departure {
    found: bool,
    hit: Hit,
    first: u32,
}

fn leave_surface(ray: Ray, texel_m: f32) -> Departure {
    var at = IN_SURFACE;
    var is_empty = false;
    var empty_m = 0.0;
    while (at.step < scene.distance_count) {
        at = next_from_surface(at, texel_m);
        counted[MARCH_STEPS]++;
        if (!is_surface(point_at(ray, at.distance_m))) {
            if (at.is_step) {
                return Departure(true, Hit(false, 0.0), at.step - 1u);
            }
            is_empty = true;
            empty_m = at.distance_m;
        } else if (is_empty) {
            return Departure(true, Hit(true, refine(ray, empty_m, at.distance_m, scene.refine)), 0u);
        } else if (at.distance_m > HIDDEN_TEXELS * texel_m) {
            break;
        }
    }
    return Departure(false, Hit(false, 0.0), 0u);
}

// Returns the proxy whose environment map is \`around\`; none for ALL_VIEWS.
fn proxy_of(around: u32) -> Sphere {
    if (around == ALL_VIEWS) {
        return Sphere(false, vec3(0.0), 0.0);
    }
    return Sphere(true, views[around].from_eye, views[around].near_m);
}

// Returns the environment map of the proxy whose surface contains a point, or ALL_VIEWS.
fn around_of(point: vec3<f32>) -> u32 {
    for (var at = 0u; at < scene.proxy_count; at++) {
        let sphere = proxy_of(scene.view_count + at);
        if (abs(length(point - sphere.centre) - sphere.radius_m) <= views[scene.view_count + at].reach_m) {
            return scene.view_count + at;
        }
    }
    return ALL_VIEWS;
}

// The surface at a hit, and the environment map of its proxy or ALL_VIEWS.
struct Front {
    surface: Patch,
    point: vec3<f32>,
    around: u32,
}

fn front_of(met: Ray, is_glass: bool) -> Front {
    let around = around_of(met.origin);
    if (is_glass && around != ALL_VIEWS) {
        let sphere = proxy_of(around);
        let entry = entry_of(sphere, met);
        let outwards = entry.point - sphere.centre;
        let size = length(outwards);
        if (entry.found && size > MIN_LENGTH) {
            return Front(Patch(true, true, outwards / size, 1.0 / sphere.radius_m, 0.0), entry.point, around);
        }
    }
    return Front(patch_at(met.origin), met.origin, ALL_VIEWS);
}

// Traces a secondary ray. \`around\` is the environment map of the proxy that the ray leaves, or ALL_VIEWS.
fn trace(ray: Ray, texel_m: f32, around: u32) -> Found {
    let nothing = Found(FOUND_NOTHING, vec3(0.0), vec3(0.0));
    counted[SECONDARY_RAYS]++;
    var left = Departure(true, Hit(false, 0.0), 0u);
    if (around == ALL_VIEWS) {
        left = leave_surface(ray, texel_m);
    }
    if (!left.found) {
        return nothing;
    }
    var hit = left.hit;
    if (!hit.found) {
        alone = around;
        hit = intersect_from(ray, left.first);
        alone = ALL_VIEWS;
    }
    if (!hit.found) {
        let seen = background_color(ray.direction);
        if (seen.found) {
            return Found(FOUND_LIGHT, vec3(0.0), light_of(seen.color));
        }
        return nothing;
    }
    let point = point_at(ray, hit.distance_m);
    let seen = surface_color(point);
    if (seen.found && seen.difference <= scene.tolerance) {
        return Found(FOUND_SURFACE, point, light_of(seen.color));
    }
    // No view sees the point directly, but one may see it through the solid.
    if (around != ALL_VIEWS) {
        alone = around;
        let through = surface_color(point);
        alone = ALL_VIEWS;
        if (through.found) {
            return Found(FOUND_LIGHT, vec3(0.0), light_of(through.color));
        }
    }
    return nothing;
}

// Returns the radiance of a traced ray times its share; pushes a surface onto the stack and returns 0 for it.
fn take(found: Found, direction: vec3<f32>, share: f32, bounces: u32) -> vec3<f32> {
    if (found.kind == FOUND_SURFACE && pending_count < MAX_PENDING) {
        pending[pending_count] = Pending(found.point, direction, found.light, share, bounces - 1u);
        pending_count++;
        return vec3(0.0);
    }
    return share * found.light;
}

// Returns the radiance recorded by views whose direction to a point is close to the eye's, and its share: 1 for a view in the
// same direction, 0 if the sine of the angle is RECORDED_SINE or more for all views.
fn recorded_of(point: vec3<f32>) -> Recorded {
    var greatest = 0.0;
    var sum = EMPTY_SUM;
    for (var number = 0u; number < view_count(); number++) {
        let view = view_at(number);
        let from_view = point - views[view].from_eye;
        let at = project(view, local_of(view, point));
        if (at.face == NO_FACE || dot(point, from_view) <= 0.0) {
            continue;
        }
        let surface = nearest_inverse_depth(at);
        if (surface == BACKGROUND || surface == UNKNOWN) {
            continue;
        }
        if (abs(log(bitcast<f32>(surface) / at.inverse_depth)) > scene.tolerance) {
            continue;
        }
        let sine = length(cross(point, views[view].from_eye)) / (length(point) * length(from_view));
        let share = clamp(1.0 - sine / RECORDED_SINE, 0.0, 1.0);
        if (share > 0.0) {
            greatest = max(greatest, share);
            sum = with_view(sum, view, at, share);
        }
    }
    let seen = seen_of(sum);
    if (!seen.found) {
        return Recorded(0.0, vec3(0.0));
    }
    return Recorded(greatest * greatest * (3.0 - 2.0 * greatest), light_of(seen.color));
}

// Moves a hit of a primary ray along the ray to the surface of the texels that contain it.
fn on_texels(point: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let from_m = length(point);
    let behind_m = from_m * exp(HOLE_DIFFERENCE);
    let ray = Ray(vec3(0.0), direction);
    counted[MARCH_STEPS] += 2u;
    if (is_surface(point) || !is_surface(point_at(ray, behind_m))) {
        return point;
    }
    return point_at(ray, refine(ray, from_m, behind_m, SETTLE_TIMES));
}

// Splits the share of a surface among its secondary rays.
fn divide(next: Pending) -> vec3<f32> {
    let whole = next.share * next.light;
    if (next.bounces == 0u) {
        return whole;
    }
    counted[MATERIAL_SAMPLES]++;
    let seen = surface_material(next.point);
    if (!seen.found) {
        return whole;
    }
    // Only hits of eye rays use recorded radiance; secondary rays arrive from other directions.
    var seen_there = Recorded(0.0, vec3(0.0));
    var point = next.point;
    if (next.bounces == scene.max_bounces) {
        if ((scene.refinements & REFINE_EDGES) != 0u) {
            point = on_texels(point, next.direction);
        }
        seen_there = recorded_of(point);
    }
    let recorded = next.share * seen_there.share * seen_there.light;
    let share = next.share - next.share * seen_there.share;
    let rest = recorded + share * next.light;
    if (share < MIN_SHARE) {
        return rest;
    }
    counted[NORMAL_EVALS]++;
    let at_point = front_of(Ray(point, next.direction), seen.refract > 0.0);
    let front = at_point.surface;
    let cosine = -dot(next.direction, front.normal);
    if (!front.found || cosine <= 0.0) {
        return rest;
    }
    let material = at_angle(seen, cosine);
    var exits: array<Exit, MAX_INSIDE>;
    if (share * material.refract >= MIN_SHARE) {
        exits = pass_through(Ray(at_point.point, next.direction), front, material.ior, proxy_of(at_point.around));
    }
    // One loop for the refracted rays and the reflected one, because drivers inline functions at each call.
    var light = vec3(0.0);
    var left = share;
    for (var at = 0u; at <= MAX_INSIDE; at++) {
        let origin = at_point.point + LIFT_TEXELS * front.texel_m * front.normal;
        var ray = Ray(origin, reflect(next.direction, front.normal));
        var part = share * material.reflect;
        if (at < MAX_INSIDE) {
            ray = exits[at].ray;
            part = share * material.refract * exits[at].part;
        }
        if (part < MIN_SHARE) {
            continue;
        }
        let found = trace(ray, front.texel_m, at_point.around);
        if (found.kind != FOUND_NOTHING) {
            light += take(found, ray.direction, part, next.bounces);
            left -= part;
        }
    }
    return recorded + light + max(left, 0.0) * next.light;
}

fn surface_light(ray: Ray, distance_m: f32, seen: Seen) -> vec3<f32> {
    pending[0] = Pending(point_at(ray, distance_m), ray.direction, light_of(seen.color), 1.0, scene.max_bounces);
    pending_count = 1u;
    var light = vec3(0.0);
    while (pending_count > 0u) {
        pending_count--;
        light += divide(pending[pending_count]);
    }
    return light;
}
`;var Dn=`// Marches over whole segments of a ray that one view proves to be empty (CALF 6, algorithm 4). Mirrors src/march/segments.rs.
// Needs \`occupancy\` and \`refine\`.

@group(0) @binding(8) var pyramids: texture_2d_array<u32>;

const ROUNDING: f32 = 1.0 / 1048576.0;
const SURELY_BELOW_ONE: f32 = 1.0 - ROUNDING;
const MIN_M: f32 = 1e-18;

// A point in the plane at depth 1 of a face; \`face\` is its index, or NO_FACE behind a perspective view.
struct PlanePlace {
    face: u32,
    // Before the division by \`planar_m\`.
    plane: vec2<f32>,
    planar_m: f32,
}

// Returns the bits of an upper bound of the inverse depths in a rectangle of texels, corners included.
fn greatest_between(face: u32, low: vec2<u32>, high: vec2<u32>) -> u32 {
    let extent = max(high.x - low.x, high.y - low.y);
    let level = select(firstLeadingBit(extent), 0u, extent == 0u);
    if (level > faces[face].levels) {
        return UNKNOWN;
    }
    var greatest = 0u;
    let first = low >> vec2(level);
    let last = high >> vec2(level);
    // Levels are stored below each other: half of the rows, a quarter, and so on.
    let rows = scene.pyramid_rows;
    let above = vec2(faces[face].pyramid_column, faces[face].pyramid_row + rows - (rows >> (max(level, 1u) - 1u)));
    for (var row = first.y; row <= last.y; row++) {
        for (var column = first.x; column <= last.x; column++) {
            let at = vec2(column, row);
            if (level == 0u) {
                greatest = max(greatest, inverse_depth_bits(face, at));
            } else {
                greatest = max(greatest, textureLoad(pyramids, above + at, faces[face].layer, 0).r);
            }
        }
    }
    return greatest;
}

fn plane_of(view: u32, local: vec3<f32>) -> PlanePlace {
    if (views[view].faces[VIEW_FACE] != NO_FACE) {
        return PlanePlace(select(NO_FACE, VIEW_FACE, local.z < 0.0), vec2(local.x, -local.y), -local.z);
    }
    let place = cube_face(local);
    return PlanePlace(place.face, place.plane, place.planar_m);
}

fn greatest_coordinate(x: vec3<f32>) -> f32 {
    return max(abs(x.x), max(abs(x.y), abs(x.z)));
}

fn is_segment_empty(view: u32, from_point: vec3<f32>, to_point: vec3<f32>, reach_m: f32) -> bool {
    let error_m = ROUNDING * (reach_m + greatest_coordinate(views[view].from_eye)) + MIN_M;
    let a_local = local_of(view, from_point);
    let b_local = local_of(view, to_point);
    let all_m = max(greatest_coordinate(a_local), greatest_coordinate(b_local)) + 2.0 * error_m;
    if (views[view].greatest_inverse_depth * all_m < SURELY_BELOW_ONE) {
        return true;
    }
    let a = plane_of(view, a_local);
    let b = plane_of(view, b_local);
    let nearest_m = min(a.planar_m, b.planar_m);
    let farthest_m = max(a.planar_m, b.planar_m) + 2.0 * error_m;
    if (a.face == NO_FACE || a.face != b.face || nearest_m < 4.0 * error_m) {
        return false;
    }
    let face = views[view].faces[a.face];
    if (face == NO_FACE) {
        return false;
    }
    let one = a.plane * (1.0 / a.planar_m);
    let two = b.plane * (1.0 / b.planar_m);
    let widths = max(abs(one), abs(two));
    let widest = max(widths.x, widths.y);
    let slack = (1.0 + widest) * (4.0 * error_m / nearest_m + ROUNDING);
    let is_view = a.face == VIEW_FACE;
    if (!is_view && widest + slack > 1.0) {
        return false;
    }
    let size = vec2(f32(faces[face].width), f32(faces[face].height));
    let margin = slack * abs(faces[face].scale) + size * ROUNDING;
    let one_at = one * faces[face].scale + faces[face].centre;
    let two_at = two * faces[face].scale + faces[face].centre;
    let low = min(one_at, two_at) - margin;
    let high = max(one_at, two_at) + margin;
    if (is_view && !(all(low >= vec2(0.0)) && all(high < size))) {
        return false;
    }
    let reach = select(0.0, AROUND_REACH, is_around);
    let from_texel = vec2<u32>(clamp(low - reach, vec2(0.0), size - 1.0));
    let to_texel = vec2<u32>(clamp(high + reach, vec2(0.0), size - 1.0));
    let greatest = greatest_between(face, from_texel, to_texel);
    return greatest != UNKNOWN && bitcast<f32>(greatest) * farthest_m < SURELY_BELOW_ONE;
}

// Returns the step at which marching ends; \`scene.distance_count\` if the ray hits nothing. Mirrors src/march/segments.rs.
fn first_step(ray: Ray, first: u32) -> u32 {
    let count = scene.distance_count;
    let origin = greatest_coordinate(ray.origin);
    let direction = greatest_coordinate(ray.direction);
    var at = first;
    // Length of the first segment: the largest that is aligned at \`first\`, at most \`scene.first_segment\`.
    var length = select(min(first & (~first + 1u), scene.first_segment), scene.first_segment, first == 0u);
    // The last point that is empty in no view, and whether a view finds it occupied.
    var blocked = count;
    var is_surface_there = false;
    while (at < count) {
        let last = min(at + length, count) - 1u;
        var passed = false;
        if (blocked == last) {
            // A segment that ends at this point cannot be empty: halve it.
            if (last == at && is_surface_there) {
                return at;
            }
            if (last == at) {
                length = 1u;
                passed = true;
            } else {
                length /= 2u;
            }
        } else {
            if (last == at) {
                length = 1u;
            }
            counted[MARCH_STEPS]++;
            let from_point = point_at(ray, distances_m[at]);
            let to_point = point_at(ray, distances_m[last]);
            let reach_m = origin + direction * distances_m[last];
            var sees_past = false;
            var behind = false;
            for (var turn = 0u; turn < view_count(); turn++) {
                let view = view_of_turn(turn);
                let says = occupancy(view, to_point);
                sees_past |= says == EMPTY;
                behind |= says == OCCUPIED;
                if (says == EMPTY && (at == last || is_segment_empty(view, from_point, to_point, reach_m))) {
                    remember_empty(view);
                    passed = true;
                    break;
                }
            }
            if (!passed && !sees_past) {
                blocked = last;
                is_surface_there = behind || until_unknown;
            }
            if (!passed && last > at) {
                length /= 2u;
            }
        }
        if (passed) {
            at += length;
            if (at % (2u * length) == 0u && length < scene.longest_segment) {
                length *= 2u;
            }
        }
    }
    return count;
}
`;var Hn=`// Converts coded colours to linear RGB. Mirrors \`light_of\` of src/march/shading.rs.

fn decoded(code: f32) -> f32 {
    if (scene.coding == CODING_LINEAR) {
        return code;
    }
    let size = abs(code);
    if (size <= 0.04045) {
        return code / 12.92;
    }
    return sign(code) * pow((size + 0.055) / 1.055, 2.4);
}

fn light_of(color: vec3<f32>) -> vec3<f32> {
    if (scene.coding == CODING_LIGHT) {
        return color;
    }
    return vec3(decoded(color.r), decoded(color.g), decoded(color.b)) * scene.gain;
}
`;var Gn=`// Refraction through a solid (CALF 6.1). Mirrors src/march/specular/solid.rs. Needs \`patch_at\`, \`surface_material\`, \`fresnel\`,
// \`is_surface\` and \`refine\`.

const FLAT: f32 = 2e-3;
const BEHIND_TEXELS: f32 = 3.0;
const MAX_INSIDE = 3u;
const NO_LIMIT_M: f32 = 1e30;

// A ray that leaves a solid, and its fraction of the entered radiance; 0 if nothing leaves.
struct Exit {
    ray: Ray,
    part: f32,
}

// A refracted direction; not found in total internal reflection.
struct Bent {
    found: bool,
    direction: vec3<f32>,
}

// Point where a ray inside a solid meets its back, and the outward normal.
struct Back {
    found: bool,
    point: vec3<f32>,
    normal: vec3<f32>,
}

// A sphere, or none. Mirrors src/march/specular/sphere.rs.
struct Sphere {
    found: bool,
    centre: vec3<f32>,
    radius_m: f32,
}

// Distance of the first point that is empty in a view.
struct FirstEmpty {
    found: bool,
    distance_m: f32,
}

fn refracted(direction: vec3<f32>, normal: vec3<f32>, ratio: f32) -> Bent {
    let cosine = clamp(-dot(direction, normal), 0.0, 1.0);
    let behind_squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if (behind_squared <= 0.0) {
        return Bent(false, vec3(0.0));
    }
    let bent = ratio * direction + (ratio * cosine - sqrt(behind_squared)) * normal;
    let size = length(bent);
    return Bent(size > MIN_LENGTH, bent / max(size, MIN_LENGTH));
}

fn first_empty(ray: Ray, texel_m: f32, limit_m: f32) -> FirstEmpty {
    var before_m = 0.0;
    var at = IN_SURFACE;
    while (at.step < scene.distance_count) {
        at = next_from_surface(at, texel_m);
        let distance_m = at.distance_m;
        if (distance_m > limit_m) {
            break;
        }
        counted[MARCH_STEPS]++;
        if (!is_surface(point_at(ray, distance_m))) {
            // The surface is at the near end of this interval.
            return FirstEmpty(true, refine(ray, distance_m, before_m, scene.refine));
        }
        before_m = distance_m;
    }
    return FirstEmpty(false, 0.0);
}

// Point where the line of a ray enters a sphere.
struct Entry {
    found: bool,
    point: vec3<f32>,
}

fn entry_of(sphere: Sphere, ray: Ray) -> Entry {
    let from_centre = ray.origin - sphere.centre;
    let along = dot(ray.direction, from_centre);
    let squared = along * along - (dot(from_centre, from_centre) - sphere.radius_m * sphere.radius_m);
    return Entry(squared > 0.0, point_at(ray, -along - sqrt(max(squared, 0.0))));
}

// Returns the distance at which a ray leaves a sphere; 0 if it misses.
fn exit_of(sphere: Sphere, ray: Ray) -> f32 {
    let from_centre = ray.origin - sphere.centre;
    let along = dot(ray.direction, from_centre);
    let squared = along * along - (dot(from_centre, from_centre) - sphere.radius_m * sphere.radius_m);
    return select(0.0, sqrt(max(squared, 0.0)) - along, squared >= 0.0);
}

fn back_of(inside: Ray, sphere: Sphere, is_whole: bool, texel_m: f32) -> Back {
    let chord_m = exit_of(sphere, inside);
    if (sphere.found && !(chord_m > 0.0)) {
        return Back(false, vec3(0.0), vec3(0.0));
    }
    var open = FirstEmpty(false, 0.0);
    if (!is_whole) {
        open = first_empty(inside, texel_m, select(NO_LIMIT_M, 2.0 * chord_m, sphere.found));
    }
    if (open.found) {
        let end = point_at(inside, open.distance_m);
        counted[NORMAL_EVALS]++;
        let material = surface_material(end);
        if (material.found && material.refract > 0.0) {
            let seen = patch_at(end);
            if (seen.found && dot(seen.normal, inside.direction) > 0.0) {
                return Back(true, end, seen.normal);
            }
        }
    }
    if (!sphere.found) {
        return Back(false, vec3(0.0), vec3(0.0));
    }
    let end = point_at(inside, select(chord_m, min(chord_m, open.distance_m), open.found));
    let outwards = end - sphere.centre;
    let size = length(outwards);
    return Back(size > MIN_LENGTH, end, outwards / max(size, MIN_LENGTH));
}

// Returns the rays that leave a solid. \`whole\` is the proxy of the solid, if it has one.
fn pass_through(ray: Ray, front: Patch, ior: f32, whole: Sphere) -> array<Exit, MAX_INSIDE> {
    var exits: array<Exit, MAX_INSIDE>;
    if (!front.bends) {
        return exits;
    }
    let bend = front.curvature;
    let behind = ray.origin + ray.direction * (BEHIND_TEXELS * front.texel_m);
    if (!whole.found && !is_surface(behind) && bend * front.texel_m < -FLAT) {
        // A concave front with empty space behind it: the ray was inside and leaves.
        let leaving = refracted(ray.direction, front.normal, ior);
        if (leaving.found) {
            exits[0] = Exit(Ray(ray.origin, leaving.direction), 1.0);
        }
        return exits;
    }
    let entering = refracted(ray.direction, front.normal, 1.0 / ior);
    if (!entering.found) {
        return exits;
    }
    var inside = Ray(ray.origin, entering.direction);
    var sphere = whole;
    if (!whole.found && bend * front.texel_m > FLAT) {
        sphere = Sphere(true, ray.origin - front.normal / bend, 1.0 / bend);
    }
    var share = 1.0;
    for (var turn = 0u; turn < MAX_INSIDE; turn++) {
        let back = back_of(inside, sphere, whole.found, front.texel_m);
        if (!back.found) {
            // A pane, which the ray passes unchanged.
            if (!sphere.found && turn == 0u) {
                exits[turn] = Exit(ray, share);
            }
            break;
        }
        var kept = 1.0;
        let leaving = refracted(inside.direction, -back.normal, ior);
        if (leaving.found) {
            kept = fresnel(dot(leaving.direction, back.normal), ior);
            exits[turn] = Exit(Ray(back.point, leaving.direction), share * (1.0 - kept));
        }
        share *= kept;
        inside = Ray(back.point, reflect(inside.direction, -back.normal));
    }
    return exits;
}
`;var zn=`// Converts depth codes to inverse depths of the texels of a view (CALF 6.2): \`write_depth\` of src/views/face_cache.rs with
// \`InverseDepth\` of src/views/inverse_depth.rs. An invocation writes a texel. Needs \`job_of\`.

@group(0) @binding(0) var<storage, read> pictures: array<u32>;
@group(0) @binding(1) var<storage, read> tables: array<u32>;
@group(0) @binding(2) var<storage, read> jobs: DepthJobs;
@group(0) @binding(3) var<storage, read_write> planes: array<u32>;

@compute @workgroup_size(WORKGROUP)
fn write_depths(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let invocation = invocation_of(id, groups);
    if (invocation >= jobs.total) {
        return;
    }
    let number = job_of(invocation);
    let job = jobs.list[number];
    let texel = invocation - job_begin(number);
    let x = texel % job.width;
    let y = texel / job.width;
    var bits = job.table;
    if (job.picture != NONE) {
        let column = job.left + x;
        let codes = pictures[job.picture + (job.top + y) * job.stride + column / 2u];
        bits = tables[job.table + ((codes >> (16u * (column % 2u))) & 0xffffu)];
        if (job.ray_length != NONE) {
            let ray_length = tables[job.ray_length + y * job.ray_length_pitch + x];
            bits = bitcast<u32>(bitcast<f32>(bits) * bitcast<f32>(ray_length));
        }
    }
    planes[job.output + y * job.pitch + x] = bits;
}
`;var $n=`// Unaligned little-endian reads of bytes, 16-bit and 32-bit words from \`stream\`.

fn byte_at(at: u32) -> u32 {
    return (stream[at >> 2u] >> ((at & 3u) * 8u)) & 255u;
}

fn word_at(at: u32) -> u32 {
    let shift = (at & 3u) * 8u;
    let low = stream[at >> 2u] >> shift;
    if (shift == 0u) {
        return low;
    }
    return low | (stream[(at >> 2u) + 1u] << (32u - shift));
}

fn half_at(at: u32) -> u32 {
    let shift = (at & 3u) * 8u;
    let low = stream[at >> 2u] >> shift;
    if (shift <= 16u) {
        return low & 0xffffu;
    }
    return (low | (stream[(at >> 2u) + 1u] << 8u)) & 0xffffu;
}
`;var Vn=`// Maps an invocation to its job and its part of the job (GDC 5, algorithm 2). Needs \`jobs\`.

// Returns the index of an invocation in a dispatch whose workgroups may extend in x and y.
fn invocation_of(id: vec3u, groups: vec3u) -> u32 {
    return id.x + id.y * groups.x * WORKGROUP;
}

// Returns the first job that ends after an invocation; requires invocation < \`jobs.total\`.
fn job_of(invocation: u32) -> u32 {
    var low = 0u;
    var high = jobs.count;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (jobs.list[middle].end <= invocation) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// Returns the first invocation of a job.
fn job_begin(job: u32) -> u32 {
    if (job == 0u) {
        return 0u;
    }
    return jobs.list[job - 1u].end;
}
`;var Wn=`// Structs and constants of kernels.json; a test compares the two.

// A depth tile or a colour cell.
struct Unit {
    // First word of its picture.
    picture: u32,
    // Size in pixels.
    width: u32,
    height: u32,
    // Words per row: \`(width + 1) / 2\` for codes, \`width\` for bytes, \`2 * width\` for halves.
    stride: u32,
    // W of its stream; 0 if every frame is coded independently, so that any frame can follow any other.
    window: u32,
    // Domain of its modelling functions: one of DOMAIN_…, the logarithm at the near distance, and codes per unit of the
    // logarithm. For the transform codec \`base\` is the first word of the stream's table sets.
    domain: u32,
    base: u32,
    scale: u32,
}

// A resident chunk.
struct Chunk {
    // Its range of rows in the table of records.
    first_record: u32,
    record_count: u32,
    // Colour only: byte offset of its weights in the stream, and their number.
    weights_at: u32,
    weight_count: u32,
}

// Change of a frame: a record of depth or material, or a keyframe of colour. For the transform codec: a frame that differs from
// the previous one.
struct Record {
    // Frame, relative to the first frame of the chunk.
    frame: u32,
    // Nodes: word offset of the header in the stream. Keyframes: byte offset of the first sample or block. Transform: byte
    // offset of the chunk.
    at: u32,
    // Range of rows in the table of boxes: boxes, or regions of the transform codec.
    first: u32,
    count: u32,
    // Number of invocations; for a keyframe, those of a blend.
    work: u32,
    // KEYFRAME_…, for keyframes only.
    coding: u32,
}

// A rectangle of values of one record, or a region of the transform codec.
struct BoxRow {
    // Position and size in the unit, in pixels.
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    // Byte offset of its values in the stream.
    at: u32,
    // One of BOX_….
    coding: u32,
    // Number of invocations of the record's boxes up to and including this one.
    end: u32,
}

// A unit to decode.
struct Item {
    unit: u32,
    // Rows in the table of chunks: the chunk of the frame, and the following chunk if the cell blends into it.
    chunk: u32,
    next: u32,
    // Frame, relative to the first frame of the chunk.
    frame: u32,
    // Identifies the chunk; never 0.
    key: u32,
}

// Current content of a unit's picture.
struct State {
    // Key of the chunk; 0 if the picture is empty.
    key: u32,
    // Frame of the chunk; for colour, the keyframe.
    frame: u32,
    // Colour only.
    weight: u32,
}

// Work on one unit.
struct Job {
    unit: u32,
    // Number of invocations of all jobs up to and including this one.
    end: u32,
    // The record to apply; for colour, the two keyframes to blend.
    record: u32,
    next: u32,
    weight: u32,
}

// Size of the next dispatch in workgroups: one invocation per part of the work (x, y, z), or one workgroup per part (part_x,
// part_y, part_z).
struct Dispatch {
    x: u32,
    y: u32,
    z: u32,
    part_x: u32,
    part_y: u32,
    part_z: u32,
}

// A rectangle of texels to convert to inverse depths.
struct DepthJob {
    // First word of the tile's picture. If NONE, every texel is set to the bits in \`table\`.
    picture: u32,
    stride: u32,
    // Position and size in the tile, in pixels.
    left: u32,
    top: u32,
    width: u32,
    // Offset of the table that maps codes to inverse depths.
    table: u32,
    // Offset of the ray length of the first texel; NONE for planar depth.
    ray_length: u32,
    ray_length_pitch: u32,
    // Offset of the first texel in the planes, in words.
    output: u32,
    pitch: u32,
    // Number of invocations of all jobs up to and including this one.
    end: u32,
}

// A rectangle of one level of a depth pyramid.
struct PyramidJob {
    // First word of the level below, or of the texels.
    below: u32,
    below_pitch: u32,
    below_width: u32,
    below_height: u32,
    left: u32,
    top: u32,
    width: u32,
    // First word of the level.
    output: u32,
    pitch: u32,
    // Upper bound of the written values, as bits of a float.
    limit: u32,
    // Number of invocations of all jobs up to and including this one.
    end: u32,
}

// Lists with their lengths; \`total\` is the number of invocations.

struct Items {
    count: u32,
    spare: u32,
    list: array<Item>,
}

struct Jobs {
    total: u32,
    count: u32,
    list: array<Job>,
}

struct DepthJobs {
    total: u32,
    count: u32,
    list: array<DepthJob>,
}

struct PyramidJobs {
    total: u32,
    count: u32,
    list: array<PyramidJob>,
}

const NONE: u32 = 0xffffffffu;
const WORKGROUP: u32 = 64u;
const MAX_GROUPS: u32 = 65535u;
const NODE_HEADER_WORDS: u32 = 12u;
const LEVELS: u32 = 9u;
const BOX_VALUES: u32 = 0u;
const BOX_CONSTANT: u32 = 1u;
const BOX_BLOCKS: u32 = 2u;
const KEYFRAME_SAMPLES: u32 = 0u;
const KEYFRAME_BLOCKS: u32 = 1u;
const DOMAIN_LOG: u32 = 0u;
const DOMAIN_LINEAR: u32 = 1u;
const DOMAIN_INVERSE: u32 = 2u;
`;var jn=`// Computes the size of the next dispatch; shared by the planning kernels. Needs \`items\`, \`jobs\` and \`dispatch\`.

// Returns the number of workgroups along x and y for \`count\` workgroups in total.
fn groups_of(count: u32) -> vec2u {
    let across = clamp(count, 1u, MAX_GROUPS);
    return vec2u(across, (count + across - 1u) / across);
}

// Writes the totals of the plan and the size of the next dispatch. Called by one invocation.
fn finish_plan(total: u32) {
    jobs.total = total;
    jobs.count = items.count;
    let invocation_groups = groups_of((total + WORKGROUP - 1u) / WORKGROUP);
    let part_groups = groups_of(total);
    dispatch = Dispatch(invocation_groups.x, invocation_groups.y, 1u, part_groups.x, part_groups.y, 1u);
}
`;var qn=`// Returns the 64-bit product of two words, low word first, computed from four 16-bit products.
fn product(one: u32, other: u32) -> vec2u {
    let a = vec2u(one & 0xffffu, one >> 16u);
    let b = vec2u(other & 0xffffu, other >> 16u);
    let low = a.x * b.x;
    let across = a.y * b.x;
    let down = a.x * b.y;
    let middle = (low >> 16u) + (across & 0xffffu) + (down & 0xffffu);
    let high = a.y * b.y + (across >> 16u) + (down >> 16u) + (middle >> 16u);
    return vec2u((middle << 16u) | (low & 0xffffu), high);
}
`;var Kn=`// Prefix sums over the invocations of a workgroup.

const SUM_WORKGROUP: u32 = 256u;

var<workgroup> sums: array<u32, SUM_WORKGROUP>;

// Returns the inclusive prefix sum of the values up to this invocation. All invocations of the workgroup must call it.
fn running_sum(local: u32, value: u32) -> u32 {
    // Waits until all invocations have read the sums of the previous call.
    workgroupBarrier();
    sums[local] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < SUM_WORKGROUP; reach *= 2u) {
        var more = 0u;
        if (local >= reach) {
            more = sums[local - reach];
        }
        workgroupBarrier();
        sums[local] += more;
        workgroupBarrier();
    }
    return sums[local];
}
`;var Ja=["nodes","boxes-codes","boxes-material","cells-8bit","cells-half","boxes-bc5","boxes-bc1","cells-bc1","cells-bc7","cells-bc6h","transform-read-8bit","transform-8bit","transform-read-half","transform-half","plan-records","plan-cells","texels","squares","render","render-pyramid","render-effects"],Za={"block/bc1.wgsl":Ir,"block/bc4.wgsl":Br,"block/bc5.wgsl":Dr,"block/bc6h.wgsl":Hr,"block/bc7.wgsl":Gr,"block/bptc.wgsl":zr,"color/blend.wgsl":$r,"color/cells.wgsl":Vr,"color/cells_of_blocks.wgsl":Wr,"color/cells_of_samples.wgsl":jr,"color/halves.wgsl":qr,"color/keyframes_bc1.wgsl":Kr,"color/keyframes_bc6h.wgsl":Xr,"color/keyframes_bc7.wgsl":Yr,"color/samples_8.wgsl":Qr,"color/samples_half.wgsl":Jr,"color/transform/chunk.wgsl":Zr,"color/transform/coder.wgsl":en,"color/transform/contexts.wgsl":tn,"color/transform/domain.wgsl":rn,"color/transform/domain_bytes.wgsl":nn,"color/transform/domain_halves.wgsl":on,"color/transform/levels.wgsl":sn,"color/transform/means.wgsl":an,"color/transform/palette.wgsl":cn,"color/transform/reconstruct.wgsl":un,"color/transform/region.wgsl":ln,"depth/bc4w.wgsl":dn,"depth/biquadratic.wgsl":fn,"depth/block_tiles.wgsl":hn,"depth/block_tiles_bc1.wgsl":mn,"depth/block_tiles_bc5.wgsl":pn,"depth/boxes_of_values.wgsl":bn,"depth/domain.wgsl":wn,"depth/platelet.wgsl":gn,"depth/record_table.wgsl":yn,"depth/records.wgsl":_n,"depth/runtime.wgsl":vn,"depth/texel_codes.wgsl":xn,"depth/texel_material.wgsl":kn,"march/active_views.wgsl":En,"march/counters.wgsl":Sn,"march/diffuse.wgsl":Rn,"march/interpolate.wgsl":An,"march/intersect.wgsl":Mn,"march/layers.wgsl":Tn,"march/layout.wgsl":Cn,"march/light_field.wgsl":On,"march/marched_views.wgsl":Pn,"march/material.wgsl":Nn,"march/normal.wgsl":Fn,"march/pyramid.wgsl":Un,"march/ray.wgsl":Ln,"march/render.wgsl":In,"march/secondary_rays.wgsl":Bn,"march/segments.wgsl":Dn,"march/shading.wgsl":Hn,"march/solid.wgsl":Gn,"march/texels.wgsl":zn,"shared/bytes.wgsl":$n,"shared/jobs.wgsl":Vn,"shared/layout.wgsl":Wn,"shared/plan.wgsl":jn,"shared/product.wgsl":qn,"shared/sums.wgsl":Kn},e2=["read-only-storage","storage","uint","unfilterable-float"];function t2(n){return e2.includes(n)}function Xn(n){let e=Oe.kernels.find(t=>t.name===n);if(e===void 0)throw new Error(`shaders/kernels.json has no kernel ${n}`);return e}function se(n){let{entry:e,workgroup:t,bindings:r,reader:o}=Xn(n),s=r.map(a=>{let[c="",u=""]=a.split(": ");if(!t2(u))throw new Error(`shaders/kernels.json: ${u} is no kind of binding`);return{name:c,kind:u}}),i=Ja.find(a=>a===o);if(i!==o)throw new Error(`shaders/kernels.json: ${o} is no kernel of the player`);return{name:n,entry:e,workgroup:t,bindings:s,reader:i}}function Yn(n){return Xn(n).files.map(t=>{let r=Za[t];if(r===void 0)throw new Error(`${t} of kernel ${n} is not part of the player`);return r}).join(`
`)}var r2=2**30,Qn=8,n2=["maxBufferSize","maxStorageBufferBindingSize","maxTextureArrayLayers","maxTextureDimension2D"],j=class extends Error{name="NoWebGpuError"},O=class extends Error{name="DeviceError"};function o2({kind:n},e){let t=GPUShaderStage.COMPUTE;return n==="read-only-storage"||n==="storage"?{binding:e,visibility:t,buffer:{type:n}}:{binding:e,visibility:t,texture:{sampleType:n,viewDimension:"2d-array"}}}async function M1(){if(!globalThis.isSecureContext)throw new j("WebGPU needs a secure page: open it by https, or from localhost.");if(typeof navigator>"u"||!("gpu"in navigator))throw new j("This browser has no WebGPU.");let n=await navigator.gpu.requestAdapter({powerPreference:"high-performance"});if(n===null)throw new j("This browser has WebGPU, but no graphics device that it may use.");return n}function Jn({info:{vendor:n,architecture:e}}){return[n,e].filter(t=>t!=="").join(" ")||"graphics device"}function T1(n){return/swiftshader|llvmpipe|lavapipe|software|basic render/iu.test(Jn(n))}var Je=class n{device;queue;name;isSoftware;maxBindingBytes;hasTimestamps;lost;onError=()=>{};#e=0;#t;#r=new Map;constructor(e,t){let{maxStorageBufferBindingSize:r,maxBufferSize:o}=e.limits,s=Math.min(r,o,r2);this.device=e,this.queue=e.queue,this.name=Jn(t),this.isSoftware=T1(t),this.maxBindingBytes=Math.floor(s/16)*16,this.hasTimestamps=e.features.has("timestamp-query"),this.lost=e.lost.then(({reason:i,message:a})=>a||i||"unknown"),e.addEventListener("uncapturederror",i=>this.onError(i.error.message))}static async open(e){let t=e??await M1();if(t.limits.maxStorageBuffersPerShaderStage<Qn)throw new j(`The graphics device gives a kernel fewer than ${Qn} buffers.`);let r=t.features.has("timestamp-query")?["timestamp-query"]:[],o=Object.fromEntries(n2.map(a=>[a,t.limits[a]])),s={label:"lightfold",requiredFeatures:r,requiredLimits:o},i=await t.requestDevice(s).catch(a=>{throw new j(`The graphics device cannot be opened: ${String(a)}.`)});return new n(i,t)}get bytes(){return this.#e}pipeline(e){let t=this.#r.get(e)??this.#n(e);return this.#r.set(e,t),t}async#n(e){let{entry:t,bindings:r}=se(e),o=this.device.createShaderModule({label:e,code:Yn(e)}),s=this.device.createBindGroupLayout({label:e,entries:r.map(o2)});return{pipeline:await this.device.createComputePipelineAsync({label:e,layout:this.device.createPipelineLayout({label:e,bindGroupLayouts:[s]}),compute:{module:o,entryPoint:t}}),layout:s,bindings:r}}bind({layout:e,bindings:t},r){let o=t.map(({name:s},i)=>({binding:i,resource:r(s)}));return this.device.createBindGroup({layout:e,entries:o})}check(e,t){if(4*t>this.maxBindingBytes)throw new O(`${e} takes ${4*t} bytes; the graphics device allows ${this.maxBindingBytes}.`)}buffer(e,t,r=0){this.check(e,t);let o=Math.max(t,4)*4,s=GPUBufferUsage.STORAGE|GPUBufferUsage.COPY_DST|GPUBufferUsage.COPY_SRC,i=this.device.createBuffer({label:e,size:o,usage:s|r});return this.#e+=o,i}scratch(e){let t=this.#t;return t!==void 0&&4*e<=t.size?t:(this.#t=this.buffer("scratch",e),t!==void 0&&this.release(t),this.#t)}filled(e,t){let r=this.buffer(e,t.length);return this.write(r,0,t),r}release(e){this.#e-=e.size,e.destroy()}write(e,t,r){this.queue.writeBuffer(e,t,r.buffer,r.byteOffset,r.byteLength)}async read(e,t,r){if(r===0)return new Uint32Array;let o=GPUBufferUsage.MAP_READ|GPUBufferUsage.COPY_DST,s=this.device.createBuffer({label:"reading back",size:4*r,usage:o});try{return this.submit(i=>i.copyBufferToBuffer(e,t,s,0,4*r)),await s.mapAsync(GPUMapMode.READ),new Uint32Array(s.getMappedRange().slice(0))}finally{s.destroy()}}submit(e){let t=this.device.createCommandEncoder();e(t),this.queue.submit([t.finish()])}destroy(){this.device.destroy()}};function b(n,e){let t=document.getElementById(n);if(!(t instanceof e))throw new Error(`index.html has no ${e.name} named ${n}`);return t}function P(n,e){let t=b(n,HTMLButtonElement);return t.addEventListener("click",e),t}function R(n,e){n.textContent!==e&&(n.textContent=e)}function Ze(n,e){for(;n.rows.length>e.length;)n.deleteRow(-1);e.forEach((t,r)=>{let o=n.rows[r]??n.insertRow();t.forEach((s,i)=>{let a=o.cells[i];a===void 0&&(a=o.appendChild(document.createElement(i===0?"th":"td")),i===0&&(a.scope="row")),R(a,s),a.classList.toggle("number",i>0&&/^[\d-]/.test(s))})})}var s2=new Intl.NumberFormat("en-US",{maximumFractionDigits:2});function D(n){return s2.format(n)}function ie(n){let e=["B","kB","MB","GB","TB"],t=n,r=0;for(;t>=999.5&&r<e.length-1;)t/=1e3,r+=1;return`${r===0?t:t.toPrecision(3)} ${e[r]}`}function et(n){return`${n.toFixed(1)} ms`}function C1(n){return/[.!?]$/.test(n)?n:`${n}.`}async function ae(n,e,t){let r=e.querySelector("span")??e,o=e.dataset.text??=r.textContent??"",s="Copied";try{await navigator.clipboard.writeText(n)}catch{s="Press Ctrl+C",t!==void 0?getSelection()?.selectAllChildren(t):s="Copy the address"}r.textContent=s,e.classList.add("says"),setTimeout(()=>{r.textContent=o,e.classList.remove("says")},1500)}function ce(n){return n instanceof Error?n.message:String(n)}var i2=4,tt=class{#e=b("messages",HTMLElement);#t=new WeakMap;say(e,t=1/0){let r=C1(e),o=[...this.#e.children],s=o.find(c=>c.firstChild?.textContent===r);if(s!==void 0){this.#r(s,t);return}o.slice(0,Math.max(0,o.length-i2+1)).forEach(c=>c.remove());let i=document.createElement("div");i.className="message",i.appendChild(document.createElement("span")).textContent=r;let a=i.appendChild(document.createElement("button"));a.type="button",a.textContent="Dismiss",a.addEventListener("click",()=>i.remove()),this.#e.appendChild(i),this.#r(i,t)}#r(e,t){clearTimeout(this.#t.get(e)),t!==1/0&&this.#t.set(e,setTimeout(()=>e.remove(),t))}clear(){this.#e.replaceChildren()}},ue=class{#e=b("notice",HTMLElement);#t=b("notice-title",HTMLElement);#r=b("notice-text",HTMLElement);#n=b("notice-webgpu",HTMLElement);#o=b("notice-command",HTMLElement);#s;#i=b("stage",HTMLElement);#a=b("tools",HTMLElement);#l=[this.#a,b("side",HTMLElement),b("transport",HTMLElement),b("state",HTMLElement)];constructor(e,t){this.#s=P("notice-retry",e),P("notice-processor",t);let r=P("notice-copy",()=>{ae(this.#o.textContent??"",r,this.#o)})}opening(e){this.#f("Opening",e),this.#n.hidden=!0,this.#s.hidden=!0}failed(e,t){let r=e instanceof j;this.#f(r?"No graphics device for this page":"The film cannot be shown",C1(ce(e))),this.#n.hidden=!r||t===void 0,R(this.#o,t??""),this.#s.hidden=!1,this.#e.focus()}hide(){this.#e.hidden=!0,this.#a.hidden=!1,this.#i.inert=!1}#f(e,t){R(this.#t,e),R(this.#r,t),this.#e.hidden=!1,this.#l.forEach(r=>r.hidden=!0),this.#i.inert=!0}};var Zn=`# Entropy tables of the transform codec (color.md 6.7): decimal numbers.
# Clusters of contexts, counted from the first of their family; a line for each family.
0 1 1 1 1 2 1 1 0 3 4 5 5 5 5 4 5 5 4 3 4 5 5 5 5 4 5 5 4 3 4 5 5 5 5 4 1 1 6 7
0 0 0 2 2 2 3 3 3 4 4 4 5 5 5 7 7 7 9 9 9 9 9 9 9 9 9 0 0 0 2 2 2 3 3 3 4 4 4 5 5 5 7 7 7 9 9 9 9 9 9 9 9 9 0 0 0 2 2 2 3 3 3 4 4 4 5 5 5 7 7 7 9 9 9 9 9 9 9 9 9 0 0 0 2 2 2 3 3 3 4 4 4 5 5 5 7 7 7 9 9 9 9 9 9 9 9 9 1 1 1 1 1 8 1 1 11 1 1 11 1 1 11 1 1 11 1 10 11 1 10 9 1 10 9 1 10 10 1 10 8 1 10 11 1 10 11 1 10 11 1 10 11 1 10 11 1 6 9 1 10 9 9 6 6 6 6 8 1 6 11 11 6 11 11 6 5 1 6 7 1 6 9 9 6 9 9 6 9 9 6 6 6 0 2 2 0 3 3 0 4 4 0 5 5 0 7 7 0 9 9 0 9 9 0 9 1 10 10 1 8 11 1 8 11 1 8 11 1 6 11 1 6 11 1 6 11 1 6 11 1 6 11 1 6 6 1 8 8 1 8 11 1 6 11 1 6 11 1 6 11 1 6 11 1 6 11 1 6 11 11 6 6 6 0 2 1 0 3 3 0 4 4 0 5 1 0 7 1 0 9 9 0 9 9 0 9 9 0 0 0 0 2 2 0 3 3 0 4 4 0 5 5 0 7 7 0 9 9 0 9 9 0 9
0 0 1 1 1 1 0 0 2 3 4 3 1 5 5 6 2 5 2 5 2 5 2 5 5 5 5 5 6 6 6 6 6 6 6 6 0 0 0 0 7 4 7 3 3 5 5 6 7 4 7 3 7 3 7 3 3 3 3 3 6 6 6 6 6 6 0 0 0 0 1 1 2 4 2 3 7 5 7 5 2 3 2 5 7 5 7 5 5 5 5 5 5 5 5 5
0 0 0 0 0 0 0 0 0 0 0 0 11 11 5 11 0 0 0 0 0 0 0 0 11 11 11 11 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 1 1 1 1 1 1 1 1 1 1 1 1 10 10 7 10 10 10 1 1 1 1 1 1 10 10 10 10 10 10 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 8 8 8 8 8 8 8 8 8 8 8 8 8 4 4 4 4 4 4 8 8 8 8 8 4 4 4 4 4 4 4 8 2 8 8 8 8 8 8 8 8 8 8 8 8 8 8 8 3 3 3 3 3 3 3 3 3 3 3 3 3 3 3 9 4 4 4 4 6 6 3 3 4 4 4 4 4 4 8 8 8 3 3 3 3 3 3 3 3 3 3 3 3 3 3 3 9 9 9 5 5 11 11 11 11 11 11 11 5 5 5 11 11 0 0 0 0 0 0 0 5 5 5 11 0 0 0 0 0 0 0 0 9 9 9 5 5 11 11 11 11 11 11 11 9 9 9 5 5 11 7 10 10 10 10 10 7 7 7 7 10 10 1 1 1 1 1 1 7 7 7 7 10 10 1 1 1 1 1 1 9 9 9 5 5 11 7 10 10 10 10 10 10 9 5 5 5 11 7 4 4 4 4 4 7 7 7 7 10 10 4 4 8 8 8 8 4 4 4 4 10 10 4 4 8 2 2 2 2 9 5 5 11 11 7 4 4 4 4 4 4 9 9 5 11 11 7 10 10 6 6 6 10 4 7 10 10 10 10 4 6 6 3 3 6 10 10 10 10 10 10 4 8 6 3 3 3 9 5 5 11 11 7 7 7 6 6 6
0 0 1 1 2 1 2 1 2 1 2 2 0 1 1 2 1 2 1 2 1 2
0 0 1 1 1 2 2 2 2 2 2 2 2 2 2 2 2 3 3 4 2 6 28 3 7 7 7 3 4 5 8 7 6 3 4 5 3 4 1 7 6 4 7 3 4 3 4 5 8 7 4 3 4 17 9 9 1 1 1 2 2 2 5 5 5 7 7 7 5 5 5 3 3 2 9 6 3 4 7 3 2 7 7 3 7 3 1 7 3 4 3 3 4 7 6 3 7 3 3 7 3 2 8 6 7 7 3 1 3 3 4 7 6 4 7 6 28 7 3 1 8 7 6 7 3 1 3 3 5 7 3 4 7 3 3 7 7 4 8 7 3 6 6 4 10 10 10 10 10 10 10 10 10 10 10 10 10 10 10 10 10 10 10 10 11 11 11 1 1 1 12 12 12 12 12 12 13 13 13 13 13 13 14 14 14 15 15 15 11 11 11 3 3 3 16 16 16 17 17 17 18 18 18 12 12 12 13 13 13 14 14 14 19 19 19 7 7 7 20 20 20 16 16 16 17 17 17 18 18 18 12 12 12 13 13 13 21 21 21 7 7 7 22 22 22 20 20 20 16 16 16 17 17 17 18 18 18 12 12 12 23 23 23 8 8 8 22 22 22 26 26 26 16 16 16 16 16 16 18 18 18 12 12 12 23 23 23 24 24 25 25 22 22 17 22 20 17 1 27 18 16 17 12 17 18 13 12 12 14 14 14 19 24 24 22 22 22 27 22 26 16 26 27 16 27 16 18 17 17 30 30 30 13 15 14 23 28 25 25 25 22 20 22 26 27 20 27 29 16 16 18 17 18 30 12 12 13 14 14 23 6 4 22 25 22 20 22 26 16 20 27 16 27 16 17 29 17 18 30 30 12 13 14 15 6 24 22 25 22 20 22 26 27 26 27 16 27 16 29 29 29 18 18 18 30 13 13 14 6 25 20 25 22 16 22 26 16 26 27 29 27 16 29 29 29 18 18 18 30 12 12 13 24 25 29 26 20 18 26 16 18 20 16 30 16 17 12 17 18 12 12 12 13 14 14 15 24 25 27 22 26 16 22 26 29 26 27 29 27 16 18 29 29 30 30 30 12 13 13 14 28 25 27 25 22 16 22 26 29 26 27 29 27 16 18 29 29 30 30 30 12 13 13 14 28 25 16 25 26 29 22 26 29 26 27 17 27 16 18 29 29 18 18 18 12 13 13 14 6 25 27 25 22 16 22 26 16 26 27 29 27 16 29 16 29 18 18 18 30 13 13 14 6 25 16 25 22 16 22 26 29 26 27 29 27 16 29 29 29 18 18 18 30 12 12 14 17 17 31 31 31 31 31 31 31 31 31 31 31 31 31 31 31 23 23 23 11 11 11 1 1 1 17 17 17 17 17 17 18 18 18 12 12 12 13 13 13 14 14 14 19 19 19 4 4 4 27 27 27 16 16 16 17 17 17 18 18 18 12 12 12 13 13 13 21 21 21 4 4 4 20 20 20 27 27 27 16 16 16 17 17 17 18 18 18 12 12 12 21 21 21 28 28 28 22 22 22 26 26 26 27 27 27 16 16 16 29 29 29 12 12 12 23 23 23 28 28 28 25 25 25 22 22 22 20 20 20 16 16 16 17 17 17 12 12 12 15 15 15 26 26 1 31 4 1 31 22 20 31 20 16 31 20 17 23 16 30 23 17 12 21 9 14 11 7 3 20 26 29 18 26 17 30 29 18 12 17 30 13 17 12 14 12 13 15 14 15 19 8 6 25 25 22 16 26 27 17 20 16 30 27 16 12 17 18 13 30 12 14 13 13 21 8 6 4 24 22 27 22 26 16 22 27 29 20 16 18 16 29 12 17 18 13 12 12 23 8 6 4 24 25 26 25 22 27 22 26 16 26 27 29 27 16 18 29 17 12 30 12 23 8 6 4 24 25 22 25 22 26 22 26 27 22 27 16 26 27 17 27 29 30 17 18 23 6 24 20 26 20 29 20 27 18 16 16 30 17 29 12 30 18 13 13 12 14 15 14 21 4 25 26 22 26 27 22 26 16 27 16 29 16 16 18 29 17 12 12 12 13 14 14 15 28 25 22 22 26 20 22 20 16 20 27 29 16 29 17 17 18 30 12 12 13 14 14 15 6 25 22 25 22 20 22 26 27 26 27 16 27 16 29 29 29 18 30 30 12 14 13 15 6 24 22 24 25 26 25 22 20 22 26 27 20 27 16 16 29 29 29 18 30 12 13 13 6 24 25 24 25 22 25 25 20 22 22 27 26 20 16 27 16 29 29 29 29 18 18 12 24 22 27 26 20 16 26 27 29 27 16 29 16 29 18 18 18 30 30 30 12 14 13 23 24 25 27 22 26 27 22 26 16 26 27 16 27 16 29 29 29 18 30 18 12 13 13 14 24 25 27 25 22 27 22 26 16 26 20 16 20 27 29 16 29 18 18 18 12 13 13 14 28 25 20 25 22 27 25 26 16 26 26 16 20 27 29 16 29 18 18 18 30 13 13 14 6 24 20 24 25 27 25 22 27 22 26 16 26 27 29 16 16 29 29 18 30 12 12 13 6 24 20 24 25 27 25 22 27 22 26 16 26 27 16 27 16 29 29 29 29 30 30 30 25 25 16 22 20 31 26 27 31 27 16 31 16 17 31 16 18 14 12 12 23 13 14 19 28 4 20 22 26 29 26 27 18 20 16 12 16 29 12 17 18 13 12 12 15 14 14 19 6 24 22 25 22 27 22 26 16 26 27 29 27 16 18 16 29 12 18 30 13 13 13 21 6 24 22 25 22 20 25 26 27 26 27 16 27 16 29 16 29 18 18 18 12 13 13 23 6 24 25 24 25 22 25 22 26 22 26 27 27 27 16 16 16 18 18 18 12 12 13 14 6 24 25 24 25 22 25 22 26 22 26 27 26 27 16 27 16 29 29 18 30 30 12 13
0 1 2 3
0
0 1
0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15
0 1
0 1
0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15
# Set 0: the frequencies of each cluster, which sum to 4096.
1882 1129 678 407
3966 1 128 1
1882 1129 678 407
1882 1129 678 407
3880 1 1 214
4090 3 2 1
3970 7 4 115
1 1 1 4093
495 3587 1 1 1 1 1 1 1 1 1 1 1 1 1 1
3017 1060 2 2 2 2 2 1 1 1 1 1 1 1 1 1
33 3831 219 1 1 1 1 1 1 1 1 1 1 1 1 1
15 3777 58 234 1 1 1 1 1 1 1 1 1 1 1 1
12 3788 31 29 225 1 1 1 1 1 1 1 1 1 1 1
31 3548 38 32 39 35 364 1 1 1 1 1 1 1 1 1
1320 2762 1 1 1 1 1 1 1 1 1 1 1 1 1 1
36 3358 38 29 31 26 30 41 500 1 1 1 1 1 1 1
1442 2349 275 14 3 2 2 1 1 1 1 1 1 1 1 1
22 3552 26 21 18 15 14 13 12 12 13 21 256 48 52 1
2141 1937 2 2 2 1 2 1 1 1 1 1 1 1 1 1
1426 1561 529 297 155 34 42 11 13 5 4 5 9 2 2 1
1 4095
10 4086
2560 1536
2560 1536
2560 1536
3 4093
469 3627
2560 1536
539 307 334 1947 962 1 2 1 1 1 1
150 327 125 206 353 2338 593 1 1 1 1
5 6 6 11 15 44 123 3199 685 1 1
383 1379 582 1006 228 130 66 99 108 98 17
1109 642 460 355 359 453 332 367 17 1 1
2407 1578 75 29 1 1 1 1 1 1 1
734 957 99 515 88 1208 223 72 99 97 4
1679 1092 120 577 346 260 18 1 1 1 1
34 130 81 146 100 175 328 2399 697 5 1
3468 603 17 1 1 1 1 1 1 1 1
1829 822 170 266 251 688 60 7 1 1 1
1238 2108 360 348 36 1 1 1 1 1 1
667 3427 1 1
1292 1843 332 629
1691 2283 56 66
1 1 1 1 1 1 1 1 43 167 148 410 638 553 1307 822
2282 1029 463 128 96 25 43 16 7 1 1 1 1 1 1 1
3877 205 1 1 1 1 1 1 1 1 1 1 1 1 1 1
3244 658 134 31 9 6 1 1 1 5 1 1 1 1 1 1
3578 458 19 29 1 1 1 1 1 1 1 1 1 1 1 1
1639 983 590 354 212 127 76 46 28 17 10 6 4 2 1 1
4081 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1
3934 147 2 1 1 1 1 1 1 1 1 1 1 1 1 1
4061 21 1 1 1 1 1 1 1 1 1 1 1 1 1 1
754 311 380 278 209 279 204 258 168 176 160 161 100 263 209 186
1 8 8 12 26 79 23 94 12 74 199 90 174 562 611 2123
1 1 48 62 119 1 81 91 30 90 39 99 169 402 169 2694
522 1361 441 548 387 213 261 87 77 85 80 1 1 13 18 1
577 882 658 310 153 191 1 187 269 376 64 131 134 67 95 1
239 570 453 456 380 137 101 304 214 82 1 1 164 905 88 1
288 1 275 438 271 1 1 1 160 1 1 1 407 275 1611 364
1603 1976 402 46 11 48 1 1 1 1 1 1 1 1 1 1
820 1792 837 425 166 46 1 1 1 1 1 1 1 1 1 1
474 1462 846 682 300 147 1 105 72 1 1 1 1 1 1 1
7 4 2043 1 1 2030 1 1 1 1 1 1 1 1 1 1
1552 2217 257 28 31 1 1 1 1 1 1 1 1 1 1 1
1 1 1 1 794 513 2319 458 1 1 1 1 1 1 1 1
1381 2701 1 1 1 1 1 1 1 1 1 1 1 1 1 1
1 107 134 1653 208 321 114 1 107 114 77 1 1 220 309 728
3420 662 1 1 1 1 1 1 1 1 1 1 1 1 1 1
1512 2491 80 1 1 1 1 1 1 1 1 1 1 1 1 1
1039 2676 291 78 1 1 1 1 1 1 1 1 1 1 1 1
489 1913 1681 1 1 1 1 1 1 1 1 1 1 1 1 1
4080 2 1 1 1 1 1 1 1 1 1 1 1 1 1 1
287 1334 935 1528 1 1 1 1 1 1 1 1 1 1 1 1
451 1300 639 625 401 670 1 1 1 1 1 1 1 1 1 1
1 275 142 64 52 154 326 156 61 238 186 77 163 449 155 1597
1639 983 590 354 212 127 76 46 28 17 10 6 4 2 1 1
1639 983 590 354 212 127 76 46 28 17 10 6 4 2 1 1
4080 2 1 1 1 1 1 1 1 1 1 1 1 1 1 1
4081 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1
4081 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1
2560 1536
2560 1536
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2090 1254 752
2560 1536
2560 1536
2560 1536
2560 1536
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
1882 1129 678 407
# Set 1: the frequencies of each cluster, which sum to 4096.
3727 1 48 320
2261 38 1614 183
3908 1 185 2
1 437 2122 1536
2869 1051 63 113
1956 531 1482 127
2475 1538 77 6
2 1425 1080 1589
160 3910 13 1 1 1 1 1 1 1 1 1 1 1 1 1
3458 624 1 1 1 1 1 1 1 1 1 1 1 1 1 1
143 3202 738 1 1 1 1 1 1 1 1 1 1 1 1 1
137 3034 332 581 1 1 1 1 1 1 1 1 1 1 1 1
114 3175 220 165 411 1 1 1 1 1 1 1 1 1 1 1
119 2965 173 135 162 122 411 1 1 1 1 1 1 1 1 1
1287 2770 22 5 1 1 1 1 1 1 1 1 1 1 1 1
103 3075 137 100 107 86 69 79 333 1 1 1 1 1 1 1
1752 2201 130 1 1 1 1 1 1 1 1 1 1 1 1 1
83 2975 89 86 80 60 53 55 44 34 37 61 277 87 74 1
2528 1554 1 1 1 1 1 1 1 1 1 1 1 1 1 1
1817 1405 645 147 54 14 5 1 1 1 1 1 1 1 1 1
64 4032
12 4084
2696 1400
1322 2774
1654 2442
924 3172
252 3844
3017 1079
899 361 397 1772 661 1 1 1 1 1 1
331 665 213 330 656 1723 174 1 1 1 1
20 28 24 31 44 101 308 3319 219 1 1
11 89 149 357 352 300 233 225 806 1473 101
1304 645 392 470 408 400 347 126 2 1 1
2376 1002 502 197 11 3 1 1 1 1 1
1076 747 262 260 250 286 445 264 346 159 1
1746 900 543 496 279 124 4 1 1 1 1
49 385 181 289 206 335 823 1682 143 2 1
3725 345 13 6 1 1 1 1 1 1 1
835 627 567 774 807 465 16 2 1 1 1
1721 1102 697 489 78 4 1 1 1 1 1
1358 2736 1 1
1280 1144 728 944
1778 950 477 891
982 535 383 253 235 219 149 178 104 79 70 50 99 172 167 421
2690 936 257 123 49 22 9 2 1 1 1 1 1 1 1 1
3112 486 175 96 63 42 31 25 17 12 6 5 10 9 5 2
3789 247 37 9 3 1 1 1 1 1 1 1 1 1 1 1
3348 641 71 20 5 1 1 1 1 1 1 1 1 1 1 1
2713 594 247 124 99 61 57 27 21 26 21 17 23 22 34 10
3911 167 5 1 1 1 1 1 1 1 1 1 1 1 1 1
3996 80 6 2 1 1 1 1 1 1 1 1 1 1 1 1
4058 23 2 1 1 1 1 1 1 1 1 1 1 1 1 1
1901 566 316 210 187 114 84 86 52 47 32 29 66 101 122 183
342 533 453 338 291 212 185 155 117 68 81 62 118 174 242 725
143 203 197 201 214 197 177 179 148 150 151 129 236 358 424 989
635 1110 874 545 331 209 133 84 56 37 28 17 19 11 6 1
502 853 809 612 423 291 181 119 83 55 42 32 38 32 18 6
354 613 616 563 500 398 264 175 124 104 80 60 88 94 49 14
243 454 459 422 391 352 309 268 220 178 149 123 182 186 105 55
1354 1728 655 215 77 32 13 8 4 2 2 1 1 2 1 1
1069 1555 796 341 160 82 35 18 12 9 5 4 4 3 2 1
872 1400 888 449 224 110 66 38 20 10 5 4 4 3 2 1
203 297 305 303 285 276 244 223 200 180 164 155 266 316 322 357
1764 1736 429 110 30 10 5 3 2 1 1 1 1 1 1 1
285 417 426 375 354 303 251 230 195 167 144 118 196 226 198 211
2216 1605 221 33 8 3 1 1 1 1 1 1 1 1 1 1
292 505 501 416 359 292 256 236 188 150 120 105 157 185 168 166
3221 820 39 4 1 1 1 1 1 1 1 1 1 1 1 1
2670 1297 102 13 3 1 1 1 1 1 1 1 1 1 1 1
1900 1729 358 73 18 7 2 1 1 1 1 1 1 1 1 1
1539 1854 509 130 35 13 5 3 1 1 1 1 1 1 1 1
3740 326 16 2 1 1 1 1 1 1 1 1 1 1 1 1
1133 1659 770 312 121 56 22 10 5 2 1 1 1 1 1 1
743 1272 903 548 282 174 84 41 18 10 6 4 4 4 2 1
565 1037 692 413 250 167 121 102 77 59 63 43 69 92 101 245
1566 1026 636 451 210 87 57 16 9 11 4 9 4 5 1 4
1319 395 555 408 423 236 252 142 88 86 53 39 44 27 14 15
997 65 125 194 166 156 279 240 297 294 358 282 192 177 161 113
3058 2 1 1 99 1 1 29 1 232 274 46 107 100 143 1
646 347 258 215 166 150 119 99 86 87 73 60 51 50 43 1646
3086 1010
1462 2634
1875 948 1273
1392 1 2703
979 1971 1146
2090 1254 752
3311 290 495
2090 1254 752
2090 1254 752
2229 1 1866
1917 1185 994
3690 1 405
1775 1840 481
2090 1254 752
3509 367 220
2090 1254 752
2090 1254 752
3641 1 454
513 3583
18 4078
3433 663
678 3418
3271 296 19 510
513 2801 73 709
289 2658 304 845
15 3674 208 199
3743 84 1 268
4038 55 2 1
946 2568 1 581
1132 1876 2 1086
3714 126 1 255
780 3030 1 285
2187 547 7 1355
1759 372 5 1960
3781 1 1 313
3932 1 1 162
4075 1 1 19
3871 1 1 223
# Set 2: the frequencies of each cluster, which sum to 4096.
3391 1 44 660
1721 7 1951 417
3838 1 227 30
1 571 2333 1191
2504 1264 55 273
1001 726 2227 142
3315 732 22 27
6 1582 1868 640
59 4008 15 2 1 1 1 1 1 1 1 1 1 1 1 1
1920 2161 2 1 1 1 1 1 1 1 1 1 1 1 1 1
30 3156 897 1 1 1 1 1 1 1 1 1 1 1 1 1
26 2734 215 1109 1 1 1 1 1 1 1 1 1 1 1 1
15 3040 139 144 747 1 1 1 1 1 1 1 1 1 1 1
37 2832 81 88 118 95 836 1 1 1 1 1 1 1 1 1
429 3608 23 16 6 4 1 1 1 1 1 1 1 1 1 1
34 3111 50 45 48 46 46 60 649 1 1 1 1 1 1 1
636 3067 349 30 3 1 1 1 1 1 1 1 1 1 1 1
32 3114 61 49 42 34 30 27 24 23 26 36 445 74 78 1
1059 3023 1 1 1 1 1 1 1 1 1 1 1 1 1 1
760 1301 954 573 256 88 89 23 20 7 4 5 13 1 1 1
12 4084
4 4092
2055 2041
764 3332
1553 2543
280 3816
155 3941
3009 1087
246 337 313 1963 1231 1 1 1 1 1 1
53 191 97 195 326 2473 757 1 1 1 1
2 5 11 28 47 160 463 2939 439 1 1
9 13 40 146 293 521 307 266 272 1805 424
588 449 239 398 465 658 712 573 12 1 1
1544 1096 770 664 15 2 1 1 1 1 1
590 947 345 384 252 243 231 352 457 288 7
911 789 623 756 604 405 4 1 1 1 1
36 58 62 200 142 226 354 2269 740 8 1
3248 799 31 11 1 1 1 1 1 1 1
591 615 462 747 852 748 71 7 1 1 1
956 887 860 1202 184 2 1 1 1 1 1
1386 2708 1 1
1008 990 811 1287
2887 544 361 304
820 462 321 86 205 178 102 78 96 35 79 43 180 141 264 1006
2051 1124 487 209 103 54 30 13 8 5 3 3 2 2 1 1
2831 583 194 119 69 55 42 30 24 21 17 9 25 27 25 25
3374 533 100 38 14 8 6 3 2 2 2 2 3 2 3 4
2912 955 138 45 20 9 5 3 2 1 1 1 1 1 1 1
2324 662 314 189 128 85 67 46 38 32 28 19 30 35 47 52
3657 414 12 1 1 1 1 1 1 1 1 1 1 1 1 1
3665 371 35 9 4 2 1 1 1 1 1 1 1 1 1 1
3922 154 7 1 1 1 1 1 1 1 1 1 1 1 1 1
1420 832 411 316 159 163 139 63 44 41 39 24 53 86 110 196
286 298 200 193 145 103 101 101 81 101 57 82 137 220 406 1585
84 132 131 135 126 122 113 120 104 95 93 90 165 280 405 1901
645 1118 854 554 346 213 131 81 51 32 21 14 16 12 6 2
457 835 734 562 412 298 206 147 106 75 56 41 57 57 36 17
360 668 616 511 412 325 248 187 144 114 87 69 100 110 85 60
364 669 621 531 433 344 264 202 151 112 84 63 85 81 53 39
1349 1718 652 224 78 33 16 9 5 3 2 1 2 2 1 1
1056 1527 773 356 162 86 48 28 17 11 8 6 5 6 4 3
886 1424 872 439 218 110 57 32 19 11 8 5 6 4 3 2
124 210 219 215 213 199 186 174 161 146 139 129 222 339 436 984
1814 1681 407 109 39 18 10 6 4 2 1 1 1 1 1 1
213 370 361 334 302 262 230 197 170 146 130 112 181 258 292 538
2271 1548 212 39 11 4 2 1 1 1 1 1 1 1 1 1
293 540 504 440 361 297 242 197 159 131 105 88 138 176 181 244
3050 983 46 5 1 1 1 1 1 1 1 1 1 1 1 1
2668 1290 106 16 4 2 1 1 1 1 1 1 1 1 1 1
1924 1705 354 75 20 6 3 1 1 1 1 1 1 1 1 1
1572 1759 540 147 44 15 7 3 2 1 1 1 1 1 1 1
3421 633 25 4 2 1 1 1 1 1 1 1 1 1 1 1
1083 1602 828 339 133 56 25 13 6 4 2 1 1 1 1 1
780 1307 905 522 268 140 73 39 22 13 9 5 6 4 2 1
558 947 609 387 275 185 133 111 88 89 54 55 92 111 116 286
1782 336 284 373 321 265 218 139 94 86 53 39 39 25 26 16
1290 181 82 145 252 244 277 266 266 237 127 205 106 162 144 112
857 34 49 112 195 89 200 386 255 341 409 322 296 157 187 207
1711 8 5 3 2 1 1 177 1 335 335 366 245 1 1 904
530 185 165 153 138 118 110 99 87 84 73 73 61 58 60 2102
3663 433
1708 2388
1344 502 2250
921 1 3174
2445 1045 606
2090 1254 752
2481 1136 479
2090 1254 752
2090 1254 752
3022 1 1073
1471 571 2054
3449 1 646
3151 685 260
2090 1254 752
2620 1132 344
2090 1254 752
2090 1254 752
3519 1 576
774 3322
22 4074
3025 1071
913 3183
2594 581 27 894
778 1623 105 1590
274 1586 188 2048
93 2841 402 760
3823 43 1 229
3931 61 1 103
1077 1572 1 1446
1553 1516 2 1025
3727 122 1 246
1891 1295 1 909
2447 453 9 1187
1555 532 4 2005
3579 1 1 515
3944 1 1 150
3695 3 2 396
3836 2 1 257
# Set 3: the frequencies of each cluster, which sum to 4096.
3468 1 1 626
1815 1 1853 427
2860 1 1125 110
1 615 1740 1740
2480 1319 141 156
946 781 2131 238
4081 12 1 2
1 670 1063 2362
120 3911 41 9 4 1 1 1 1 1 1 1 1 1 1 1
2914 1168 1 1 1 1 1 1 1 1 1 1 1 1 1 1
61 1804 2218 1 1 1 1 1 1 1 1 1 1 1 1 1
52 1864 174 1994 1 1 1 1 1 1 1 1 1 1 1 1
39 1611 107 130 2198 1 1 1 1 1 1 1 1 1 1 1
104 1683 73 55 60 93 2019 1 1 1 1 1 1 1 1 1
1278 2774 16 8 6 3 2 1 1 1 1 1 1 1 1 1
76 2012 47 33 33 24 59 96 1709 1 1 1 1 1 1 1
1535 2120 414 14 2 1 1 1 1 1 1 1 1 1 1 1
50 2189 43 19 15 21 19 13 19 29 30 59 1165 195 229 1
2149 1933 1 1 1 1 1 1 1 1 1 1 1 1 1 1
1508 1794 259 260 169 18 39 9 14 4 4 5 10 1 1 1
61 4035
5 4091
2332 1764
702 3394
1858 2238
305 3791
186 3910
2855 1241
243 189 251 2214 1193 1 1 1 1 1 1
42 111 61 107 114 2795 862 1 1 1 1
2 2 1 3 2 10 27 3254 793 1 1
8 36 7 9 9 15 10 24 37 2825 1116
1316 787 336 359 228 352 196 490 30 1 1
2259 738 459 573 61 1 1 1 1 1 1
691 927 382 432 232 307 193 188 280 444 20
1993 779 407 325 192 366 28 3 1 1 1
23 28 35 50 28 72 66 2827 962 4 1
3826 249 6 8 1 1 1 1 1 1 1
886 533 405 529 334 1192 169 38 3 6 1
1213 584 556 1433 304 1 1 1 1 1 1
1473 2621 1 1
492 676 709 2219
3995 58 14 29
65 101 240 411 1091 149 356 840 401 363 52 1 2 7 8 9
2317 1159 360 121 91 20 4 2 1 1 1 15 1 1 1 1
3253 519 153 63 36 24 11 8 7 5 2 3 2 4 3 3
3524 460 66 19 9 5 3 2 1 1 1 1 1 1 1 1
2950 963 119 32 14 5 3 2 1 1 1 1 1 1 1 1
2703 749 276 129 72 37 29 20 14 13 9 7 12 12 9 5
3165 891 25 3 1 1 1 1 1 1 1 1 1 1 1 1
3386 614 58 18 6 3 2 1 1 1 1 1 1 1 1 1
3535 504 35 8 2 2 1 1 1 1 1 1 1 1 1 1
1781 1427 425 243 145 26 7 6 5 3 3 2 3 4 6 10
380 714 510 404 270 311 396 229 174 112 96 100 140 115 72 73
150 294 303 292 266 253 204 194 156 149 132 123 201 289 355 735
894 1387 880 456 220 106 54 32 18 12 9 6 8 8 5 1
640 1112 863 577 369 221 129 73 43 24 14 9 10 8 3 1
568 1022 812 555 355 229 154 98 68 51 36 32 40 44 21 11
219 407 386 348 311 283 259 235 214 191 171 158 255 335 256 68
1627 1735 510 142 45 17 7 4 2 1 1 1 1 1 1 1
1409 1666 634 220 82 33 16 8 6 4 3 3 4 4 3 1
1115 1604 814 331 133 53 22 10 5 2 2 1 1 1 1 1
198 371 393 361 330 275 226 206 171 146 132 119 187 255 289 437
2007 1651 317 76 23 8 4 2 1 1 1 1 1 1 1 1
276 522 519 454 375 308 241 194 158 135 110 94 146 180 169 215
2387 1489 171 28 8 3 1 1 1 1 1 1 1 1 1 1
403 726 628 468 339 253 189 153 124 102 88 75 125 161 146 116
2994 1060 28 2 1 1 1 1 1 1 1 1 1 1 1 1
2631 1338 97 15 4 1 1 1 1 1 1 1 1 1 1 1
2148 1617 256 48 12 4 2 1 1 1 1 1 1 1 1 1
1833 1731 396 90 25 9 3 1 1 1 1 1 1 1 1 1
2815 1167 84 15 4 1 1 1 1 1 1 1 1 1 1 1
1282 1712 719 243 84 30 12 5 2 1 1 1 1 1 1 1
859 1382 899 485 243 121 56 27 12 5 2 1 1 1 1 1
1023 1564 679 282 151 86 67 39 26 25 14 13 20 28 26 53
3317 252 161 168 40 25 89 11 15 7 3 3 2 1 1 1
3318 71 39 31 29 20 52 70 99 82 83 41 43 43 23 52
3807 14 101 39 1 1 1 11 23 36 8 11 20 1 11 11
4053 1 1 1 1 1 1 1 1 1 8 8 1 8 1 8
2308 40 27 25 26 27 27 24 26 24 25 30 26 25 21 1415
2770 1326
1320 2776
917 1707 1472
1557 1 2538
547 2480 1069
2090 1254 752
1260 1879 957
2090 1254 752
2090 1254 752
2473 1 1622
357 2485 1254
3592 1 503
579 3011 506
2090 1254 752
268 1738 2090
2090 1254 752
2090 1254 752
3399 1 696
1748 2348
70 4026
1335 2761
893 3203
1 701 1 3393
686 41 1913 1456
78 680 1 3337
1032 6 4 3054
1882 1129 678 407
1882 1129 678 407
685 16 10 3385
3692 206 124 74
249 149 90 3608
2952 1 1 1142
1882 1129 678 407
3216 99 59 722
3641 1 1 453
4081 1 1 13
2839 61 36 1160
1882 1129 678 407
# Set 4: the frequencies of each cluster, which sum to 4096.
4080 1 1 14
3977 90 24 5
3968 1 105 22
1024 1024 1024 1024
3480 594 1 21
3606 449 5 36
2954 1135 6 1
1024 1024 1024 1024
208 3874 1 1 1 1 1 1 1 1 1 1 1 1 1 1
2382 1700 1 1 1 1 1 1 1 1 1 1 1 1 1 1
36 3933 114 1 1 1 1 1 1 1 1 1 1 1 1 1
50 3951 22 61 1 1 1 1 1 1 1 1 1 1 1 1
23 3966 23 20 53 1 1 1 1 1 1 1 1 1 1 1
66 3859 19 18 7 26 92 1 1 1 1 1 1 1 1 1
668 3414 1 1 1 1 1 1 1 1 1 1 1 1 1 1
44 3888 11 10 5 9 10 23 89 1 1 1 1 1 1 1
606 3432 45 1 1 1 1 1 1 1 1 1 1 1 1 1
35 3925 11 6 2 2 12 5 2 16 9 21 35 7 7 1
1461 2621 1 1 1 1 1 1 1 1 1 1 1 1 1 1
1441 1626 491 276 144 32 39 10 12 4 4 4 9 1 2 1
29 4067
1 4095
3420 676
426 3670
639 3457
954 3142
1453 2643
3114 982
1158 942 187 1301 502 1 1 1 1 1 1
223 1761 186 567 598 719 38 1 1 1 1
5 6 6 11 15 44 123 3199 685 1 1
97 476 293 657 648 762 348 187 363 261 4
553 509 386 520 393 430 999 303 1 1 1
1654 1733 357 283 45 17 3 1 1 1 1
339 390 203 327 353 554 686 325 568 350 1
500 1350 427 1010 481 304 18 3 1 1 1
96 830 285 774 373 339 659 717 21 1 1
2973 1068 27 21 1 1 1 1 1 1 1
276 1006 402 920 828 539 101 21 1 1 1
910 1934 503 628 105 10 2 1 1 1 1
528 3566 1 1
1231 1809 454 602
1286 1687 401 722
828 439 173 144 149 68 96 74 26 18 56 16 94 183 896 836
1585 1081 607 318 195 130 103 47 18 2 4 2 1 1 1 1
3529 409 48 30 18 14 12 8 7 9 4 2 2 1 2 1
3063 726 191 52 22 20 11 3 1 1 1 1 1 1 1 1
3272 581 113 53 32 19 13 4 2 1 1 1 1 1 1 1
2367 510 274 161 132 87 63 61 54 48 26 18 32 90 101 72
4062 20 1 1 1 1 1 1 1 1 1 1 1 1 1 1
3897 180 6 1 1 1 1 1 1 1 1 1 1 1 1 1
4075 7 1 1 1 1 1 1 1 1 1 1 1 1 1 1
1259 688 448 290 190 137 120 98 117 76 53 82 61 106 172 199
91 232 235 257 158 192 120 110 115 105 61 65 133 258 355 1609
10 25 25 27 30 26 34 38 35 48 37 42 80 147 243 3249
263 510 505 512 500 448 335 224 166 136 102 64 99 110 98 24
215 435 455 474 397 400 238 179 163 146 107 98 177 200 240 172
139 279 262 324 287 279 253 198 198 160 115 100 194 338 358 612
97 101 145 134 206 305 284 215 222 115 160 123 242 321 393 1033
1033 1404 878 442 184 93 34 13 3 4 2 1 2 1 1 1
700 1186 736 488 325 211 120 93 68 39 24 22 39 32 12 1
426 833 696 642 452 275 160 141 118 83 54 45 69 58 39 5
46 86 98 72 91 120 90 120 108 113 109 96 193 335 489 1930
1734 1484 533 193 81 30 21 9 3 2 1 1 1 1 1 1
45 96 110 136 175 159 171 212 144 162 151 138 269 429 662 1037
2050 1746 228 49 10 3 1 1 1 1 1 1 1 1 1 1
58 81 138 162 149 176 208 202 251 249 246 186 332 482 448 728
3737 340 6 1 1 1 1 1 1 1 1 1 1 1 1 1
2442 1382 200 40 16 5 2 1 1 1 1 1 1 1 1 1
1147 2254 541 115 24 5 1 1 1 1 1 1 1 1 1 1
1178 1659 862 246 104 22 14 3 1 1 1 1 1 1 1 1
4051 31 1 1 1 1 1 1 1 1 1 1 1 1 1 1
390 907 927 758 415 266 126 92 58 55 26 25 23 20 7 1
278 783 662 444 295 327 190 197 152 140 103 100 163 173 79 10
173 472 371 284 250 166 158 123 112 90 87 69 118 211 297 1115
2515 916 281 191 61 88 12 9 6 3 1 5 3 1 2 2
2496 430 411 308 49 220 87 1 8 32 10 13 11 1 6 13
3714 1 1 166 1 1 65 1 1 1 1 1 1 1 139 1
256 256 256 256 256 256 256 256 256 256 256 256 256 256 256 256
2238 97 79 37 17 14 9 8 5 5 4 3 5 2 2 1571
2510 1586
1184 2912
969 7 3120
242 1 3853
2784 111 1201
1366 1365 1365
3538 147 411
1366 1365 1365
1366 1365 1365
2543 1 1552
817 733 2546
3988 1 107
3526 112 458
1366 1365 1365
3185 694 217
1366 1365 1365
1366 1365 1365
3748 1 347
233 3863
124 3972
2544 1552
507 3589
2456 668 62 910
1857 667 1 1571
69 410 138 3479
2251 922 52 871
3734 360 1 1
1024 1024 1024 1024
1044 1044 1 2007
1024 1024 1024 1024
4092 2 1 1
2274 1 1 1820
4092 2 1 1
1 2682 1 1412
3254 1 1 840
3800 1 1 294
3535 1 1 559
2047 1 1 2047
# Set 5: the frequencies of each cluster, which sum to 4096.
3849 1 3 243
3207 34 657 198
3569 1 349 177
1024 1024 1024 1024
2264 1739 29 64
2052 1686 288 70
1795 2270 30 1
1024 1024 1024 1024
191 3881 11 1 1 1 1 1 1 1 1 1 1 1 1 1
3510 572 1 1 1 1 1 1 1 1 1 1 1 1 1 1
184 3215 684 1 1 1 1 1 1 1 1 1 1 1 1 1
159 2952 262 711 1 1 1 1 1 1 1 1 1 1 1 1
122 3319 164 109 371 1 1 1 1 1 1 1 1 1 1 1
128 3101 133 108 142 77 398 1 1 1 1 1 1 1 1 1
1317 2719 30 13 4 3 1 1 1 1 1 1 1 1 1 1
102 3308 92 90 80 72 40 35 270 1 1 1 1 1 1 1
1823 2140 116 5 1 1 1 1 1 1 1 1 1 1 1 1
70 3400 85 64 58 49 45 37 32 19 17 18 167 21 13 1
2554 1528 1 1 1 1 1 1 1 1 1 1 1 1 1 1
1786 1142 764 224 102 33 23 7 5 3 1 1 2 1 1 1
20 4076
3 4093
2374 1722
52 4044
175 3921
70 4026
197 3899
2588 1508
810 340 360 1750 830 1 1 1 1 1 1
420 706 192 279 559 1672 264 1 1 1 1
13 7 10 10 4 18 62 3336 634 1 1
6 54 53 293 239 246 270 415 814 1446 260
1189 730 370 439 321 401 365 278 1 1 1
2296 1045 504 235 9 2 1 1 1 1 1
1100 625 232 257 316 297 359 260 437 212 1
1696 961 528 466 291 149 1 1 1 1 1
49 522 177 335 197 325 639 1506 344 1 1
3764 315 7 3 1 1 1 1 1 1 1
781 585 572 844 869 407 27 8 1 1 1
1653 1027 824 523 60 4 1 1 1 1 1
1096 2998 1 1
933 1153 723 1287
2825 601 190 480
624 312 219 131 94 84 70 74 70 74 75 73 128 258 390 1420
2701 843 281 128 66 34 21 10 4 2 1 1 1 1 1 1
2749 561 225 141 111 79 48 42 30 28 16 15 17 19 12 3
3540 423 83 23 9 5 3 2 1 1 1 1 1 1 1 1
3603 414 43 17 6 3 1 1 1 1 1 1 1 1 1 1
2831 620 249 136 73 40 34 15 10 7 8 6 10 8 10 39
3963 109 11 1 1 1 1 1 1 1 1 1 1 1 1 1
3803 241 25 9 4 3 2 1 1 1 1 1 1 1 1 1
4018 61 4 1 1 1 1 1 1 1 1 1 1 1 1 1
2062 555 255 156 108 82 63 56 51 45 39 36 65 100 142 281
196 331 297 260 212 180 143 142 107 89 99 76 130 209 294 1331
57 97 99 101 124 104 104 114 103 113 101 105 193 355 535 1791
581 1059 782 552 368 239 163 100 68 49 39 24 33 27 10 2
399 700 656 547 425 352 210 175 134 101 71 62 87 89 65 23
301 545 520 459 387 306 252 211 170 144 101 86 138 177 162 137
338 457 482 441 387 258 252 224 196 130 122 90 143 183 192 201
1276 1683 652 252 107 59 26 16 9 5 3 2 2 2 1 1
943 1491 789 388 194 116 61 38 27 18 10 7 6 5 2 1
815 1352 850 473 250 145 71 50 32 19 12 8 9 7 2 1
132 182 209 159 202 230 158 176 168 159 153 149 264 412 510 833
1569 1750 499 158 66 23 13 7 3 2 1 1 1 1 1 1
224 343 338 316 301 267 255 236 175 167 147 131 218 292 309 377
2208 1640 164 51 15 6 3 1 1 1 1 1 1 1 1 1
285 564 514 476 353 326 280 175 169 142 125 84 140 177 154 132
3705 361 16 2 1 1 1 1 1 1 1 1 1 1 1 1
2596 1335 123 21 8 3 1 1 1 1 1 1 1 1 1 1
1841 1756 345 97 28 13 5 3 1 1 1 1 1 1 1 1
1383 1794 629 154 72 31 14 7 4 2 1 1 1 1 1 1
3944 130 9 1 1 1 1 1 1 1 1 1 1 1 1 1
1076 1626 775 357 116 63 35 20 9 5 4 3 3 2 1 1
653 1192 847 542 317 211 100 73 49 31 22 15 21 16 6 1
421 982 658 398 251 176 136 104 68 64 48 46 71 117 150 406
2627 864 294 207 57 25 10 2 1 1 1 3 1 1 1 1
2026 552 536 409 63 286 114 1 9 41 13 16 10 1 3 16
2445 1 1 799 1 1 174 1 1 1 1 1 1 1 666 1
256 256 256 256 256 256 256 256 256 256 256 256 256 256 256 256
1448 331 270 124 56 44 28 26 16 16 11 8 15 5 6 1692
2377 1719
1075 3021
993 1 3102
194 1 3901
2708 22 1366
1366 1365 1365
3709 153 234
1366 1365 1365
1366 1365 1365
2174 1 1921
793 723 2580
3991 1 104
3631 44 421
1366 1365 1365
3683 292 121
1366 1365 1365
1366 1365 1365
3467 1 628
240 3856
121 3975
2514 1582
490 3606
2360 762 72 902
1871 643 1 1581
71 424 73 3528
2268 928 52 848
3691 403 1 1
1024 1024 1024 1024
1154 1036 1 1905
1024 1024 1024 1024
4093 1 1 1
2311 1 1 1783
4092 2 1 1
1 2682 1 1412
3235 1 1 859
3801 1 1 293
3535 1 1 559
2047 1 1 2047
# Set 6: the frequencies of each cluster, which sum to 4096.
4080 1 10 5
3754 71 254 17
3718 1 369 8
1024 1024 1024 1024
2876 1209 9 2
2761 1244 86 5
2002 2089 4 1
1024 1024 1024 1024
121 3938 21 4 1 1 1 1 1 1 1 1 1 1 1 1
3127 955 1 1 1 1 1 1 1 1 1 1 1 1 1 1
88 3225 770 1 1 1 1 1 1 1 1 1 1 1 1 1
77 3017 368 622 1 1 1 1 1 1 1 1 1 1 1 1
60 3029 236 221 539 1 1 1 1 1 1 1 1 1 1 1
76 2826 178 127 177 168 535 1 1 1 1 1 1 1 1 1
1130 2930 20 4 1 1 1 1 1 1 1 1 1 1 1 1
70 2834 132 89 108 91 93 121 551 1 1 1 1 1 1 1
1480 2472 131 1 1 1 1 1 1 1 1 1 1 1 1 1
78 2808 95 111 97 67 54 62 48 41 43 71 309 110 101 1
2381 1701 1 1 1 1 1 1 1 1 1 1 1 1 1 1
1701 1626 545 144 53 14 4 1 1 1 1 1 1 1 1 1
31 4065
2 4094
2377 1719
739 3357
140 3956
436 3660
198 3898
3104 992
753 450 530 1870 487 1 1 1 1 1 1
199 435 204 356 709 2052 137 1 1 1 1
16 28 33 42 69 185 481 3088 152 1 1
17 31 42 53 81 173 228 289 624 2478 80
1184 562 342 442 465 482 415 200 2 1 1
2270 996 564 254 6 1 1 1 1 1 1
1135 1088 341 329 206 189 257 268 218 64 1
1639 831 590 562 342 127 1 1 1 1 1
56 166 140 245 180 326 784 2088 107 3 1
3699 369 17 4 1 1 1 1 1 1 1
772 673 517 742 838 530 20 1 1 1 1
1545 981 792 662 110 1 1 1 1 1 1
1212 2882 1 1
996 1086 881 1133
1907 869 497 823
926 557 293 149 135 111 95 124 103 86 75 76 147 224 316 679
2486 937 322 151 96 52 26 12 5 2 2 1 1 1 1 1
3580 336 81 40 21 13 8 5 3 2 1 1 1 2 1 1
3474 507 77 17 8 3 1 1 1 1 1 1 1 1 1 1
3362 653 48 13 6 3 2 1 1 1 1 1 1 1 1 1
2960 410 176 98 74 57 50 28 25 27 20 26 20 27 29 69
3951 128 4 1 1 1 1 1 1 1 1 1 1 1 1 1
3629 425 26 4 1 1 1 1 1 1 1 1 1 1 1 1
3901 176 6 1 1 1 1 1 1 1 1 1 1 1 1 1
1898 581 320 199 149 116 98 81 66 66 49 46 67 85 89 186
245 460 361 328 273 226 191 159 132 108 96 85 130 179 245 878
83 154 152 154 165 133 133 133 114 113 111 106 197 321 439 1588
769 1335 849 517 270 147 83 43 28 18 12 7 8 6 3 1
577 1016 809 570 381 252 140 103 67 46 30 24 30 26 18 7
393 743 652 528 425 311 226 170 132 100 64 56 79 86 70 61
379 571 601 490 437 282 256 191 180 121 104 76 114 119 104 71
1656 1804 465 114 32 11 4 2 1 1 1 1 1 1 1 1
1260 1732 699 240 89 38 15 8 4 3 2 1 1 2 1 1
1045 1619 804 352 145 66 27 15 9 4 3 2 2 1 1 1
191 325 361 258 275 283 190 197 167 154 141 121 214 317 343 559
2073 1671 271 51 15 4 2 1 1 1 1 1 1 1 1 1
286 511 482 424 359 293 248 214 151 135 113 96 150 191 188 255
2613 1371 84 14 3 1 1 1 1 1 1 1 1 1 1 1
344 671 580 510 355 288 237 159 140 111 97 67 110 141 129 157
3795 281 7 1 1 1 1 1 1 1 1 1 1 1 1 1
3094 951 35 4 1 1 1 1 1 1 1 1 1 1 1 1
2189 1656 198 34 7 2 1 1 1 1 1 1 1 1 1 1
1704 1827 431 87 27 8 3 1 1 1 1 1 1 1 1 1
3705 371 7 1 1 1 1 1 1 1 1 1 1 1 1 1
1204 1695 728 301 89 42 17 9 4 1 1 1 1 1 1 1
704 1418 872 471 256 162 63 55 32 22 11 8 10 8 3 1
395 841 566 372 248 182 146 104 95 75 76 56 101 135 165 539
3087 615 189 69 87 10 4 3 24 1 1 2 1 1 1 1
2744 460 353 193 30 202 54 1 5 20 7 8 6 1 4 8
3289 1 1 381 1 1 96 1 1 1 1 1 1 1 318 1
256 256 256 256 256 256 256 256 256 256 256 256 256 256 256 256
1670 223 112 73 11 21 6 17 3 16 2 2 3 1 1 1935
2239 1857
1177 2919
954 7 3135
242 1 3853
2726 58 1312
1366 1365 1365
3528 135 433
1366 1365 1365
1366 1365 1365
2089 1 2006
761 957 2378
3999 1 96
3638 65 393
1366 1365 1365
3672 276 148
1366 1365 1365
1366 1365 1365
3473 1 622
165 3931
99 3997
2544 1552
507 3589
2456 668 62 910
1857 667 1 1571
69 410 138 3479
2251 922 52 871
3734 360 1 1
1024 1024 1024 1024
1044 1044 1 2007
1024 1024 1024 1024
4092 2 1 1
2274 1 1 1820
4092 2 1 1
1 2682 1 1412
3254 1 1 840
3800 1 1 294
3535 1 1 559
2047 1 1 2047
# Set 7: the frequencies of each cluster, which sum to 4096.
4084 1 1 10
3875 70 140 11
3981 1 107 7
1024 1024 1024 1024
2982 1104 9 1
2626 1303 166 1
2477 1613 5 1
1024 1024 1024 1024
168 3881 28 6 2 1 1 1 1 1 1 1 1 1 1 1
3380 702 1 1 1 1 1 1 1 1 1 1 1 1 1 1
74 2812 1197 1 1 1 1 1 1 1 1 1 1 1 1 1
66 2944 153 921 1 1 1 1 1 1 1 1 1 1 1 1
60 2523 81 109 1312 1 1 1 1 1 1 1 1 1 1 1
55 2613 74 62 57 82 1144 1 1 1 1 1 1 1 1 1
1360 2713 6 2 4 1 1 1 1 1 1 1 1 1 1 1
70 3274 30 27 25 16 39 47 561 1 1 1 1 1 1 1
1812 2006 252 12 3 1 1 1 1 1 1 1 1 1 1 1
59 3436 24 14 11 18 17 15 7 14 19 36 381 35 9 1
2524 1558 1 1 1 1 1 1 1 1 1 1 1 1 1 1
1023 1313 587 627 386 43 70 14 8 4 5 5 8 1 1 1
48 4048
1 4095
3483 613
687 3409
1693 2403
245 3851
305 3791
2320 1776
632 275 204 1958 1021 1 1 1 1 1 1
72 342 92 179 140 2345 922 1 1 1 1
1 1 1 1 1 1 5 2403 1680 1 1
10 14 15 17 18 16 8 4 2 2347 1645
1376 867 420 439 259 377 236 119 1 1 1
2597 795 454 236 8 1 1 1 1 1 1
585 774 566 634 340 470 260 186 223 57 1
2152 781 439 388 226 104 2 1 1 1 1
17 79 60 88 29 78 64 2381 1298 1 1
3990 94 3 2 1 1 1 1 1 1 1
993 564 489 745 424 651 183 44 1 1 1
2006 815 534 660 75 1 1 1 1 1 1
1168 2926 1 1
618 707 589 2182
3573 294 100 129
701 564 392 258 250 171 124 130 96 101 82 59 114 173 300 581
2623 952 277 97 64 35 26 10 3 2 1 2 1 1 1 1
3377 462 108 52 30 20 13 7 6 10 5 1 2 1 1 1
3547 456 58 14 5 4 3 1 1 1 1 1 1 1 1 1
3468 573 33 8 3 1 1 1 1 1 1 1 1 1 1 1
3039 499 124 88 62 50 30 22 18 16 15 14 18 24 30 47
3422 596 60 6 1 1 1 1 1 1 1 1 1 1 1 1
3346 644 69 19 6 2 1 1 1 1 1 1 1 1 1 1
3211 756 97 18 3 1 1 1 1 1 1 1 1 1 1 1
2118 583 253 174 145 111 75 77 54 45 37 33 58 87 82 164
245 451 437 352 293 235 204 161 118 102 110 92 139 218 270 669
109 203 182 180 189 158 161 143 121 109 103 91 170 284 361 1532
896 1482 866 440 209 97 48 24 13 8 4 2 3 2 1 1
663 1171 870 549 317 197 104 69 41 27 21 16 21 17 10 3
536 942 745 547 377 242 163 114 81 67 40 36 52 64 49 41
568 933 791 568 402 241 165 104 72 47 31 28 36 44 40 26
1526 1850 553 121 27 8 2 1 1 1 1 1 1 1 1 1
1330 1808 669 195 57 19 7 3 1 1 1 1 1 1 1 1
1204 1766 761 246 73 25 8 4 2 1 1 1 1 1 1 1
238 397 409 293 294 291 204 179 156 127 110 96 152 213 255 682
1772 1811 409 74 16 4 1 1 1 1 1 1 1 1 1 1
310 574 526 442 370 297 238 191 137 119 97 76 118 157 169 275
1966 1782 287 44 6 1 1 1 1 1 1 1 1 1 1 1
409 785 670 543 376 295 227 139 116 89 73 49 77 90 78 80
3515 561 7 1 1 1 1 1 1 1 1 1 1 1 1 1
2256 1588 215 24 2 1 1 1 1 1 1 1 1 1 1 1
1755 1848 405 67 9 2 1 1 1 1 1 1 1 1 1 1
1597 1879 517 78 13 2 1 1 1 1 1 1 1 1 1 1
2731 1220 117 15 2 1 1 1 1 1 1 1 1 1 1 1
1395 1876 643 145 22 5 1 1 1 1 1 1 1 1 1 1
1105 1719 817 301 93 34 10 6 3 2 1 1 1 1 1 1
492 840 549 360 227 169 130 104 76 55 56 57 90 137 173 581
2362 887 563 209 34 16 6 5 3 2 1 3 2 1 1 1
2066 529 505 379 60 271 107 1 10 39 13 16 13 1 70 16
3138 1 2 452 2 2 114 1 1 1 1 1 1 1 377 1
256 256 256 256 256 256 256 256 256 256 256 256 256 256 256 256
1197 245 134 109 42 106 101 9 6 6 4 3 6 2 2 2124
2126 1970
1550 2546
940 68 3088
301 1 3794
2611 226 1259
1366 1365 1365
3486 144 466
1366 1365 1365
1366 1365 1365
2294 1 1801
851 648 2597
3987 1 108
3450 187 459
1366 1365 1365
3512 382 202
1366 1365 1365
1366 1365 1365
3292 1 803
194 3902
235 3861
2502 1594
464 3632
2456 668 62 910
1857 667 1 1571
69 410 138 3479
2251 922 52 871
3734 360 1 1
1024 1024 1024 1024
1044 1044 1 2007
1024 1024 1024 1024
4092 2 1 1
2274 1 1 1820
4092 2 1 1
1 2682 1 1412
3225 1 1 869
3800 1 1 294
3535 1 1 559
2047 1 1 2047
# Set 8: the frequencies of each cluster, which sum to 4096.
4072 1 7 16
3607 54 421 14
3825 1 263 7
1024 1024 1024 1024
2594 1491 10 1
2347 1588 160 1
2020 2070 5 1
1024 1024 1024 1024
41 4024 18 1 1 1 1 1 1 1 1 1 1 1 1 1
1676 2405 2 1 1 1 1 1 1 1 1 1 1 1 1 1
17 2443 1623 1 1 1 1 1 1 1 1 1 1 1 1 1
15 2451 274 1344 1 1 1 1 1 1 1 1 1 1 1 1
14 2649 194 153 1075 1 1 1 1 1 1 1 1 1 1 1
18 2575 98 110 117 91 1078 1 1 1 1 1 1 1 1 1
390 3648 24 15 6 3 1 1 1 1 1 1 1 1 1 1
5 2944 77 35 49 33 50 62 834 1 1 1 1 1 1 1
638 2856 557 31 3 1 1 1 1 1 1 1 1 1 1 1
18 2889 55 34 33 29 26 24 27 24 31 51 648 106 100 1
871 3211 1 1 1 1 1 1 1 1 1 1 1 1 1 1
556 1224 1043 672 320 93 103 25 22 6 5 7 17 1 1 1
6 4090
1 4095
2576 1520
176 3920
302 3794
123 3973
81 4015
3427 669
223 249 253 2010 1355 1 1 1 1 1 1
41 127 87 152 240 2407 1038 1 1 1 1
4 4 9 27 52 166 442 2717 673 1 1
3 7 3 12 15 45 44 65 167 2281 1454
437 383 222 387 423 687 676 846 33 1 1
1510 984 807 759 29 2 1 1 1 1 1
146 325 233 267 210 205 214 478 945 1038 35
902 594 636 680 620 640 20 1 1 1 1
21 26 50 107 109 170 233 2224 1147 8 1
3317 707 47 18 1 1 1 1 1 1 1
594 498 429 632 706 1124 104 6 1 1 1
1024 718 788 1336 224 1 1 1 1 1 1
1305 2789 1 1
701 870 781 1744
3287 319 212 278
501 423 383 225 230 221 151 115 114 109 87 74 182 212 355 714
2519 850 351 166 82 44 33 20 12 4 6 2 3 1 2 1
3120 562 177 89 43 28 19 13 9 9 8 5 5 4 4 1
3447 484 101 30 13 6 4 2 2 1 1 1 1 1 1 1
3294 728 44 13 5 2 1 1 1 1 1 1 1 1 1 1
2536 792 322 149 80 39 29 23 17 15 12 11 17 20 15 19
3599 480 4 1 1 1 1 1 1 1 1 1 1 1 1 1
3395 585 71 21 9 4 2 1 1 1 1 1 1 1 1 1
3694 343 34 11 3 1 1 1 1 1 1 1 1 1 1 1
1712 702 374 231 163 130 90 72 51 50 49 32 58 96 99 187
232 345 314 287 253 244 197 191 153 140 120 107 183 271 280 779
86 158 154 154 156 126 134 130 117 116 105 105 180 310 434 1631
772 1345 902 516 266 134 69 36 21 12 8 5 5 3 1 1
566 1042 817 561 368 248 140 99 70 47 33 24 30 29 17 5
486 899 729 534 374 259 187 135 99 73 58 47 64 71 51 30
516 882 759 567 413 270 197 132 96 63 47 34 42 39 25 14
1301 1710 692 250 85 32 11 5 3 1 1 1 1 1 1 1
1045 1617 832 356 140 56 23 11 6 3 2 1 1 1 1 1
953 1558 901 410 160 63 24 11 6 3 2 1 1 1 1 1
165 303 323 247 259 254 192 191 172 159 142 127 212 315 374 661
1681 1667 492 161 56 19 7 4 2 1 1 1 1 1 1 1
244 458 435 386 340 294 257 221 169 153 132 113 179 231 226 258
2599 1262 160 47 14 4 1 1 1 1 1 1 1 1 1 1
397 746 650 541 389 310 242 159 133 102 83 56 86 92 64 46
3400 680 3 1 1 1 1 1 1 1 1 1 1 1 1 1
3086 930 53 13 3 1 1 1 1 1 1 1 1 1 1 1
2163 1499 303 89 24 7 2 1 1 1 1 1 1 1 1 1
1699 1677 499 149 45 13 4 2 1 1 1 1 1 1 1 1
3299 687 72 20 7 1 1 1 1 1 1 1 1 1 1 1
1095 1666 841 333 106 32 10 4 2 1 1 1 1 1 1 1
877 1492 922 459 195 82 32 16 7 4 3 2 2 1 1 1
564 1015 633 379 259 179 122 96 71 69 49 45 90 103 130 292
2179 642 341 216 212 125 42 138 98 20 1 21 20 1 20 20
2066 529 505 379 60 271 107 1 10 39 13 16 76 1 7 16
3138 1 2 452 2 2 114 1 1 1 1 1 1 1 377 1
256 256 256 256 256 256 256 256 256 256 256 256 256 256 256 256
484 108 70 45 45 60 58 11 2 2 25 24 10 1 1 3150
2724 1372
1686 2410
975 5 3116
242 1 3853
2685 119 1292
1366 1365 1365
3014 159 923
1366 1365 1365
1366 1365 1365
1573 1 2522
869 445 2782
3942 1 153
3578 125 393
1366 1365 1365
3279 183 634
1366 1365 1365
1366 1365 1365
2998 1 1097
329 3767
244 3852
2706 1390
615 3481
2631 498 42 925
1808 748 1 1539
65 386 250 3395
2217 907 52 920
3795 299 1 1
1024 1024 1024 1024
891 1055 1 2149
1024 1024 1024 1024
4092 2 1 1
2228 1 1 1866
4092 2 1 1
1 2682 1 1412
3384 1 1 710
3800 1 1 294
3535 1 1 559
2047 1 1 2047
# Set 9: the frequencies of each cluster, which sum to 4096.
4092 1 2 1
3441 105 549 1
3752 1 340 3
1024 1024 1024 1024
3178 883 34 1
2620 1003 472 1
1889 2179 27 1
1024 1024 1024 1024
54 3964 47 11 6 3 2 1 1 1 1 1 1 1 1 1
2709 1373 1 1 1 1 1 1 1 1 1 1 1 1 1 1
51 735 3297 1 1 1 1 1 1 1 1 1 1 1 1 1
49 629 161 3245 1 1 1 1 1 1 1 1 1 1 1 1
26 548 84 144 3283 1 1 1 1 1 1 1 1 1 1 1
157 845 62 53 59 108 2803 1 1 1 1 1 1 1 1 1
1255 2773 26 14 8 6 3 2 2 1 1 1 1 1 1 1
100 758 38 36 36 30 72 141 2878 1 1 1 1 1 1 1
1331 2217 516 19 2 1 1 1 1 1 1 1 1 1 1 1
48 986 58 25 21 25 26 15 29 44 46 87 1881 351 453 1
2024 2058 1 1 1 1 1 1 1 1 1 1 1 1 1 1
1579 1933 181 188 118 13 34 8 16 4 4 4 11 1 1 1
36 4060
1 4095
2201 1895
515 3581
1877 2219
133 3963
411 3685
3253 843
135 154 272 2348 1181 1 1 1 1 1 1
31 46 52 72 99 3009 783 1 1 1 1
2 2 1 4 3 15 54 3361 652 1 1
8 4 5 5 6 14 12 34 38 3209 761
1355 788 287 305 202 298 179 635 45 1 1
2282 631 409 686 82 1 1 1 1 1 1
868 1308 286 328 161 213 161 133 143 471 24
2017 825 378 274 164 397 33 5 1 1 1
19 15 20 28 27 62 65 3074 779 6 1
3485 582 1 21 1 1 1 1 1 1 1
923 553 378 382 284 1387 135 36 6 11 1
1028 520 529 1641 372 1 1 1 1 1 1
1162 2932 1 1
371 504 618 2603
3764 144 75 113
586 380 386 231 197 61 121 67 97 128 72 56 95 200 357 1062
2515 967 288 124 93 45 26 15 8 6 3 1 1 2 1 1
3496 339 115 53 31 18 12 8 6 4 2 3 4 3 1 1
3744 293 36 9 3 1 1 1 1 1 1 1 1 1 1 1
3241 805 30 7 2 1 1 1 1 1 1 1 1 1 1 1
3142 463 173 83 48 33 29 22 13 12 8 8 13 17 13 19
3370 707 6 1 1 1 1 1 1 1 1 1 1 1 1 1
3249 777 45 10 3 2 1 1 1 1 1 1 1 1 1 1
3483 580 18 3 1 1 1 1 1 1 1 1 1 1 1 1
2051 713 309 189 138 95 72 60 54 41 39 33 58 71 67 106
228 448 379 279 212 179 156 118 110 78 74 58 110 178 226 1263
76 136 128 121 105 103 96 95 84 85 80 82 146 245 375 2139
834 1373 865 471 240 125 71 41 25 15 10 7 8 7 3 1
682 1171 820 506 305 186 119 82 55 38 29 21 27 28 18 9
533 929 709 497 343 249 174 127 93 70 55 45 64 73 71 64
353 655 598 485 381 316 249 200 145 117 93 66 100 118 112 108
1952 1682 337 83 23 7 3 1 1 1 1 1 1 1 1 1
1587 1700 520 168 62 25 13 6 4 3 2 1 2 1 1 1
1151 1683 808 299 94 31 12 6 4 2 1 1 1 1 1 1
152 277 265 240 232 211 190 175 158 147 128 119 207 307 397 891
2492 1434 127 24 7 2 1 1 1 1 1 1 1 1 1 1
217 422 393 354 314 276 237 203 169 151 129 111 188 255 272 405
2756 1264 58 6 1 1 1 1 1 1 1 1 1 1 1 1
322 615 554 467 377 307 246 196 160 131 108 86 132 157 131 107
3400 682 1 1 1 1 1 1 1 1 1 1 1 1 1 1
3002 1057 24 1 1 1 1 1 1 1 1 1 1 1 1 1
2473 1473 120 16 3 1 1 1 1 1 1 1 1 1 1 1
2181 1652 210 35 7 1 1 1 1 1 1 1 1 1 1 1
3136 933 14 1 1 1 1 1 1 1 1 1 1 1 1 1
1534 1766 571 168 40 7 1 1 1 1 1 1 1 1 1 1
1055 1676 886 331 96 26 10 5 3 2 1 1 1 1 1 1
687 1010 541 316 204 130 107 83 64 56 45 41 70 107 145 490
2608 846 299 203 65 30 12 9 6 4 1 5 3 1 2 2
2099 537 513 385 61 275 109 1 10 40 13 16 13 1 7 16
3138 1 2 452 2 2 114 1 1 1 1 1 1 1 377 1
256 256 256 256 256 256 256 256 256 256 256 256 256 256 256 256
1418 314 253 118 54 45 31 26 16 16 12 10 16 6 7 1754
2384 1712
1103 2993
984 7 3105
242 1 3853
2705 59 1332
1366 1365 1365
3585 151 360
1366 1365 1365
1366 1365 1365
2162 1 1933
804 708 2584
3987 1 108
3602 70 424
1366 1365 1365
3660 295 141
1366 1365 1365
1366 1365 1365
3457 1 638
240 3856
132 3964
2544 1552
507 3589
2456 668 62 910
1857 667 1 1571
69 410 138 3479
2251 922 52 871
3734 360 1 1
1024 1024 1024 1024
1044 1044 1 2007
1024 1024 1024 1024
4092 2 1 1
2274 1 1 1820
4092 2 1 1
1 2682 1 1412
3254 1 1 840
3800 1 1 294
3535 1 1 559
2047 1 1 2047
`;var eo=`# Entropy tables of predictive depth (depth.md 15.8): decimal numbers.
# Clusters of contexts, counted from the first of their family; a line for each family.
0 1
0 1 2 3 4 5 5 6 7 8 8 9 10 11 10 12 12 9 12 11 9 12 11 9 12 13 9 12 11 9 0 1 2 3 4 5 14 15 16 16 6 16 17 17 2 1 18 19 1 12 19 1 20 19 1 12 19 1 13 19 1 9 19 14 15 16 16 6 7 7 6 16 16 6 7 7 6 7 7 7 18 18 18 1 1 1 1 1 1 1 11 11 0 0 1 1 1 6 16 8 8 9 17 17 2 2 6 7 13 13 21 22 10 22 12 13 23 12 12 23 12 13 23 12 13 23 12 13 23 24 24 21 18 10 21 0 18 19 19 17 17 18 22 22 25 26 26 27 28 20 29 20 30 31 31 20 32 33 20 32 33 33 26 34 34 10 10 9 1 9 19 19 1 1 22 21 22 26 26 26 28 28 20 35 35 35 27 27 20 20 12 20 20 33 33 33 33 10 10 11 9 1 9 19 19 0 0 22 22 32 29 35 35 35 20 35 36 20 35 35 20 35 31 35 33 32 1 20 32 32 18 18 8 21 0 9 19 19 11 0 22 22 21 30 22 30 31 33 30 32 22 33 30 23 33 32 23 33 32 23 33 34 34 34 10 0 21 1 9 19 19 6 1 22 13 21 37 30 30 31 20 33 35 32 35 31 23 33 20 23 33 32 23 33 34 18 21 10 8 21 1 9 19 19 1 1 22 13 21 30 33 33 32 33 33 32 31 33 32 23 33 32 23 33 32 23 33 22 1 34 0 1 2 14 38 16 16 6 7 11 11 9 18 18 28 28 12 39 20 20 28 28 12 39 39 12 39 20 0 39 7 19 14
0 1 2 2 3 4 2 5 6 7 7 7 3 3 7 7 8 9 8 8 10 10 11 11 12 6 7 7 13 13 14 15
0 1 2 3 4 5 6 7 8 9 10 11
0 0 1 1 1 1 1 2 1 0 0 0 0 0 1 1 1 3 0 0 4 5 4 5 6 6 6 3 4 5 4 5 4 5 6 5 5 3 4 5 6 6 6 7 6 7 7 8 6 5 1 1 9 9 9 10 10 8 9 11 12 12 12 12 12 12 12 13 12 12 12 8 8 8 8 8 8 14 14 2 15 16 15 17 17 17 17 2 17 17 0 0 0 0 1 6 6 3 0 0 18 19 19 19 6 6 6 3 19 0 18 20 18 20 21 5 5 3 18 20 22 23 22 23 6 5 5 3 22 5 24 24 24 24 6 6 6 8 24 24 9 9 9 9 9 9 9 8 9 25 26 26 27 7 12 12 12 8 26 12 12 28 28 8 8 8 8 29 29 8 17 17 17 17 17 17 17 2 17 17 4 5 4 5 6 5 5 3 4 5 30 20 30 20 21 5 5 3 30 20 31 32 33 34 35 36 36 3 37 38 39 40 39 23 21 5 5 3 39 41 24 24 24 24 6 6 6 8 24 6 42 43 42 43 42 43 43 8 42 25 26 26 26 7 44 44 44 8 26 12 12 28 28 28 28 29 29 45 45 29 46 16 17 16 47 47 47 2 48 49 4 5 4 5 6 5 5 3 4 5 50 50 50 50 6 6 6 3 50 6 51 52 39 40 21 5 5 3 51 41 52 40 38 53 7 54 54 3 38 41 50 41 41 55 7 56 56 2 41 55 6 56 6 56 43 43 43 8 43 11 26 7 27 7 12 12 12 8 26 12 12 28 28 28 28 14 14 14 14 2 46 57 47 57 47 17 17 2 58 59 60 60 60 60 60 60 60 2 60 60 60 60 60 60 60 60 60 2 60 60 60 7 60 7 60 7 7 2 60 41 60 54 41 54 7 56 56 2 41 55 41 54 55 55 11 57 57 2 55 59 60 11 11 57 10 61 61 2 11 57 12 12 12 12 12 12 12 13 12 12 12 2 2 2 2 2 2 14 14 2 46 46 47 47 47 47 47 57 59 59 62 62 62 62 63 63 63 2 62 25 64 64 64 64 63 25 25 2 64 25 65 66 67 66 63 25 25 13 65 11 67 66 67 11 63 11 11 2 67 11 67 11 11 56 10 57 57 2 11 57 63 68 25 68 69 70 70 71 72 73 16 74 16 74 74 75 75 13 16 76 76 77 77 2 2 71 71 77 77 2 47 15 47 15 47 15 15 2 78 79 64 64 64 64 64 64 64 8 64 67 27 27 27 27 64 64 64 8 27 67 80 36 27 27 26 26 26 28 80 26 27 27 27 27 67 67 67 8 27 67 67 67 67 67 67 67 67 2 67 16 63 25 63 25 81 82 82 13 76 76 44 44 83 83 84 85 85 13 16 16 16 29 29 29 29 13 13 29 29 29 15 15 15 15 15 15 15 17 46 46 46 14 14 14 14 14 14 14 14 14 14 86 86 86 86 14 14 14 14 29 29 45 45 86 86 28 28 14 14 29 29 86 86 86 86 14 14 14 14 2 2 14 14 14 14 14 14 14 14 2 2 87 87 87 87 87 87 87 87 2 2 88 88 88 88 88 88 88 88 2 2 89 89 90 90 91 91 92 92 93 93 2 2 2 2 2 2 93 93 93 17 17 17 17 17 17 17 2 17 17 17 17 17 17 47 47 47 2 17 17 48 49 58 59 47 47 47 2 46 46 58 59 58 59 47 59 59 2 46 46 59 59 59 59 59 59 59 2 46 46 78 15 78 15 15 15 15 2 46 46 47 15 47 15 15 15 15 2 46 46 46 93 93 2 2 2 2 93 93 94 94 94 94 94 46 46 46 94 95 95
0 0 1 1 1 1 2 3 4 5 5 6 7 7 8 9 9 10 11 11 12 13 14 15 16 17 18 17 17 19 19 19 19 19 19 19
0 1 2
# Set 0: the frequencies of each cluster, which sum to 4096.
2 4094
2228 1868
3748 24 1 317 1 1 1 1 1 1
3906 145 7 32 1 1 1 1 1 1
3143 905 6 6 6 6 6 6 6 6
2254 1812 1 23 1 1 1 1 1 1
2101 1933 46 10 1 1 1 1 1 1
881 3207 1 1 1 1 1 1 1 1
1488 238 2363 1 1 1 1 1 1 1
2807 936 2 339 2 2 2 2 2 2
2594 7 1 1488 1 1 1 1 1 1
791 982 58 933 108 181 82 245 536 180
1655 72 53 1130 487 124 77 261 148 89
2714 5 1 1370 1 1 1 1 1 1
460 55 47 1232 75 1102 105 90 794 136
1806 1 1 2282 1 1 1 1 1 1
179 3909 1 1 1 1 1 1 1 1
40 4048 1 1 1 1 1 1 1 1
13 4075 1 1 1 1 1 1 1 1
2238 1402 4 428 4 4 4 4 4 4
412 76 53 1222 1641 67 78 392 80 75
334 3734 6 16 1 1 1 1 1 1
82 103 53 238 163 1686 176 99 1306 190
358 415 54 1339 220 79 94 698 259 580
246 60 49 2157 585 132 107 413 158 189
116 181 53 1053 90 297 88 201 806 1211
2727 6 1 1356 1 1 1 1 1 1
59 53 53 93 3499 56 65 112 53 53
65 64 53 135 3170 54 53 395 53 54
61 53 53 181 277 2827 170 92 305 77
69 53 53 161 55 3005 111 54 480 55
67 53 53 112 1185 147 2112 184 107 76
75 76 53 273 1701 199 229 1156 120 214
82 53 53 258 522 1511 325 522 618 152
115 54 53 487 684 760 308 471 694 470
65 243 53 257 344 396 103 418 646 1571
125 109 53 484 1242 53 54 1859 57 60
65 75 53 133 259 1037 1895 139 329 111
68 53 53 94 160 176 3224 66 131 71
87 53 53 138 2835 188 312 211 82 137
141 3943 5 1 1 1 1 1 1 1
96 156 53 418 53 1083 53 63 2063 58
2716 82 122 121 362 322 371
2848 63 33 109 457 301 285
2818 83 34 76 432 297 356
3280 125 1 1 664 18 7
2580 317 53 63 967 61 55
2949 87 2 2 421 271 364
2923 10 48 22 356 400 337
2297 563 148 116 93 513 366
3325 1 141 1 1 620 7
2423 28 280 29 28 1278 30
3746 6 6 47 154 92 45
2865 1 73 1 21 1010 125
2731 35 105 66 342 424 393
2942 115 1 8 913 33 84
2422 45 22 41 552 514 500
2496 1 37 1 547 594 420
488 898 1298 168 384 86 240 56 103 54 63 83 59 66 50
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
393 1146 1332 339 338 85 82 49 50 49 46 48 47 46 46
2122 315 694 115 216 77 116 56 66 54 55 54 55 50 51
2585 294 431 85 127 62 77 52 60 51 50 63 56 54 49
1332 593 981 154 363 87 143 56 80 53 51 52 53 49 49
2295 407 722 62 136 28 94 17 36 18 27 58 66 69 61
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
1320 229 365 426 990 162 366 33 66 12 53 12 60 1 1
538 113 71 443 452 323 383 165 164 96 195 228 507 222 196
10 260 507 573 1360 108 623 1 196 2 229 1 193 26 7
1132 137 201 281 562 138 352 67 140 57 219 95 463 92 160
1226 1187 829 227 387 1 1 15 3 1 54 165
770 468 988 146 804 1 2 37 36 4 212 628
182 188 96 107 22 1650 257 420 75 6 738 355
1392 668 434 78 50 1413 1 19 6 1 22 12
1406 1283 711 238 245 1 1 24 2 1 64 120
1322 886 663 355 210 41 1 51 77 1 297 192
986 823 667 353 276 3 1 83 79 5 462 358
988 878 592 583 144 4 1 114 56 3 567 166
744 554 337 119 78 1481 3 278 117 8 231 146
559 454 469 207 366 3 2 154 75 43 754 1010
276 348 207 470 150 1 2 255 91 49 1577 670
394 649 165 777 78 5 4 346 43 6 1288 341
542 373 354 211 195 11 2 581 133 64 864 766
88 23 20 5 4 852 1 1327 112 521 869 274
277 96 164 20 22 3363 1 35 42 1 27 48
77 58 45 51 33 22 649 202 34 1 1488 1436
91 44 39 21 20 1 27 2702 217 11 520 403
1217 1371 314 237 102 29 512 6 1 1 149 157
1971 1598 318 134 32 1 1 7 1 1 14 18
1453 1907 363 209 88 1 3 6 1 1 27 37
1922 1285 503 153 86 45 1 12 1 1 34 53
1518 761 643 197 141 1 1 151 120 1 325 237
1760 1309 601 243 79 1 1 11 1 1 64 25
1467 1156 497 663 55 28 1 9 1 1 184 34
1472 915 828 456 153 1 2 18 3 1 200 47
237 213 179 257 197 6 1 188 96 38 1419 1265
1188 534 459 138 116 4 2 931 64 3 343 314
1318 707 631 194 162 2 1 643 28 5 200 205
1171 330 367 17 13 1874 1 137 113 2 11 60
208 104 53 11 6 3294 9 51 103 58 172 27
2241 1265 424 73 48 1 1 7 1 1 14 20
2811 774 465 15 10 1 1 5 1 1 5 7
2641 839 458 42 15 55 1 6 1 1 9 28
2530 945 521 44 23 1 1 7 1 1 11 11
2077 1130 493 241 38 38 1 7 1 1 43 26
1961 627 495 85 55 1 1 200 117 1 338 215
2151 683 480 130 45 57 1 200 109 1 142 97
2666 862 472 28 15 1 11 5 1 1 17 17
1822 533 1459 111 103 1 2 7 1 1 37 19
2388 589 940 75 57 1 1 7 1 1 23 13
1627 1103 661 498 61 26 1 10 1 1 88 19
1251 1038 917 504 136 1 2 18 2 1 189 37
1086 420 407 150 132 1 3 262 105 39 788 703
611 439 404 304 184 9 3 200 88 64 1125 665
893 305 267 66 53 11 1 1473 169 65 435 358
307 96 76 4 4 3573 1 7 1 1 5 21
78 27 29 6 7 10 2830 81 1 1 646 380
757 317 362 112 109 8 660 203 36 1 724 807
2198 592 513 48 28 1 537 1 1 1 108 68
1466 556 378 172 23 444 744 5 3 1 199 105
1753 779 1161 111 195 1 1 10 1 1 33 50
2361 409 1174 26 89 1 2 8 1 1 12 12
2122 360 1447 50 78 2 1 6 1 1 17 11
538 1862 241 1265 21 3 1 2 1 1 154 7
766 1715 189 1055 31 4 1 10 6 1 304 14
540 1566 166 1351 28 1 1 7 1 1 417 17
400 971 150 1125 64 6 1 59 24 6 1157 133
205 612 79 1105 44 2 1 53 21 11 1798 165
1578 505 1090 105 148 1 464 1 1 1 134 68
753 779 661 642 161 79 315 9 1 1 545 150
1335 694 1246 243 271 1 1 41 9 1 152 102
152 357 110 574 79 9 1 66 39 44 2358 307
335 166 489 84 537 1 1 766 64 15 504 1134
379 206 203 119 124 1 3 587 171 19 1182 1102
619 326 447 107 261 6 3 905 49 7 658 708
795 295 276 77 60 1 5 800 9 3 971 804
496 390 261 269 118 64 1 651 48 3 1177 618
640 439 294 238 87 1 4 966 43 6 834 544
98 219 96 397 111 25 1 62 36 36 2065 950
42 30 26 34 24 1 6 311 139 116 1875 1492
9 10 7 19 7 6 1 90 66 75 2426 1380
2 5 6 4 2 550 1 135 154 104 2278 855
57 43 36 43 35 1 38 339 123 1 1845 1535
8 8 5 20 3 8 110 94 74 1 2006 1759
36 18 18 12 8 1 5 2086 375 220 736 581
7 5 5 5 4 13 2 965 636 311 1227 916
161 86 80 54 44 1 63 884 234 1 1195 1293
5 3 4 2 3 2021 2 125 40 42 1341 508
148 64 61 39 30 1 560 17 1 1 1662 1512
24 24 11 37 10 53 1066 43 1 1 1994 832
1952 619 516 74 65 1 1 530 8 4 147 179
142 94 90 69 57 1 5 1006 283 215 1103 1031
20 18 15 19 13 10 1 1013 440 459 869 1219
429 230 203 92 74 5 1 2400 102 52 281 227
41 25 25 17 18 1 2 2760 306 220 363 318
6 5 6 4 5 7 1 2382 651 537 285 207
288 116 111 14 13 3517 1 16 1 1 3 15
33 21 12 5 6 2728 8 257 94 409 256 267
43 12 16 2 3 2296 2 984 246 261 66 165
83 24 24 1 1 3930 1 1 1 1 1 28
68 29 22 3 1 3936 1 2 1 1 1 31
38 16 11 1 1 3256 4 184 540 1 7 37
5 1 1 1 1 4048 1 1 1 1 1 34
22 10 10 1 1 3325 614 1 1 1 8 102
207 74 84 14 19 74 3440 1 1 1 162 19
1 1 1 1 1 3 4014 1 1 1 23 48
428 182 211 102 119 75 103 77 128 88 142 115 172 248 543 1363
1558 381 272 128 133 68 91 53 77 54 69 53 67 96 269 727
1564 537 471 204 179 95 111 67 86 58 75 52 79 81 176 261
2256 686 461 163 142 59 55 23 24 14 23 8 12 19 39 112
2242 705 399 156 132 71 64 36 37 21 29 14 21 26 56 87
1217 845 916 364 258 99 94 48 56 28 29 17 18 16 35 56
1133 1016 1159 350 167 60 59 33 32 21 12 4 5 5 9 31
398 385 785 688 803 351 227 90 89 57 60 30 28 21 34 50
177 247 703 811 1279 513 140 46 51 33 30 10 10 7 13 26
143 136 285 297 651 596 803 389 264 106 121 67 66 48 58 66
28 40 117 210 782 904 1035 603 138 55 55 31 27 18 22 31
89 86 176 155 305 319 612 486 686 371 277 116 130 100 99 89
15 14 28 32 85 208 913 920 1096 441 122 52 60 47 35 28
62 48 75 57 102 95 179 165 379 438 950 581 312 233 230 190
22 22 45 51 101 105 234 258 559 502 964 582 250 162 147 92
5 4 9 9 16 18 56 168 951 928 1164 539 77 70 53 29
38 29 47 37 64 58 94 82 143 135 269 263 526 745 1041 525
10 9 16 15 31 30 61 65 152 215 399 347 741 948 845 212
2 1 2 3 5 5 11 13 30 74 169 279 630 931 1432 509
1 1 1 1 2 3 4 5 12 14 46 175 1834 1696 201 100
413 442 229 353 265 378 271 361 235 309 326 267 141 62 32 12
251 262 157 221 165 263 239 396 304 433 468 372 264 163 109 29
219 256 174 271 206 339 291 434 328 461 444 350 195 86 34 8
# Set 1: the frequencies of each cluster, which sum to 4096.
3170 926
3282 814
4040 48 1 1 1 1 1 1 1 1
4063 1 25 1 1 1 1 1 1 1
1941 2147 1 1 1 1 1 1 1 1
1918 2162 2 2 2 2 2 2 2 2
3418 1 670 1 1 1 1 1 1 1
844 3244 1 1 1 1 1 1 1 1
2770 1 1318 1 1 1 1 1 1 1
736 3328 4 4 4 4 4 4 4 4
1698 100 62 1693 79 69 54 142 117 82
791 982 58 933 108 181 82 245 536 180
1655 72 53 1130 487 124 77 261 148 89
744 108 56 2245 53 158 55 86 514 77
340 63 53 1216 84 1070 118 102 896 154
604 64 54 2546 96 91 67 171 203 200
48 4040 1 1 1 1 1 1 1 1
2448 2 1632 2 2 2 2 2 2 2
13 4075 1 1 1 1 1 1 1 1
1345 849 91 1292 116 101 61 85 84 72
412 76 53 1222 1641 67 78 392 80 75
3968 7 72 7 7 7 7 7 7 7
82 103 53 238 163 1686 176 99 1306 190
358 415 54 1339 220 79 94 698 259 580
267 65 53 1991 635 143 117 448 171 206
116 181 53 1053 90 297 88 201 806 1211
765 93 61 2037 174 53 54 692 96 71
59 53 53 93 3499 56 65 112 53 53
65 64 53 135 3170 54 53 395 53 54
61 53 53 181 277 2827 170 92 305 77
69 53 53 161 55 3005 111 54 480 55
67 53 53 112 1185 147 2112 184 107 76
75 76 53 273 1701 199 229 1156 120 214
82 53 53 258 522 1511 325 522 618 152
115 54 53 487 684 760 308 471 694 470
65 243 53 257 344 396 103 418 646 1571
125 109 53 484 1242 53 54 1859 57 60
65 75 53 133 259 1037 1895 139 329 111
68 53 53 94 160 176 3224 66 131 71
87 53 53 138 2835 188 312 211 82 137
3094 13 898 13 13 13 13 13 13 13
96 156 53 418 53 1083 53 63 2063 58
1241 726 958 80 323 637 131
644 660 389 149 521 348 1385
2373 484 82 92 622 260 183
1770 848 56 60 1235 66 61
2377 360 60 71 1096 69 63
2111 447 112 142 741 237 306
2016 114 499 138 171 839 319
1786 341 297 248 419 384 621
1687 56 1039 55 63 1137 59
1730 58 567 58 56 1565 62
3495 67 57 67 225 116 69
2209 56 190 55 133 1334 119
1870 79 644 97 206 1012 188
2013 187 65 64 1465 173 129
2211 93 77 75 621 677 342
2181 169 153 118 547 511 417
196 970 1402 181 415 93 260 61 112 59 68 90 63 72 54
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
261 1238 1273 366 365 92 89 53 54 53 50 52 50 50 50
2122 315 694 115 216 77 116 56 66 54 55 54 55 50 51
2688 143 448 88 132 64 80 55 62 53 52 66 58 56 51
1389 449 1021 160 378 91 148 58 83 55 53 54 55 51 51
276 469 603 360 703 148 639 84 270 76 151 107 89 64 57
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
661 446 338 857 778 201 250 90 92 71 84 55 73 50 50
1331 158 372 257 904 120 199 87 165 79 107 106 97 58 56
1703 167 272 285 765 76 148 67 200 63 92 77 73 57 51
1362 127 333 259 872 133 218 92 155 82 111 116 110 63 63
329 182 334 20 179 7 7 1095 405 101 572 865
327 141 362 41 321 1 1 428 194 77 1515 688
138 112 99 184 165 468 281 362 123 21 809 1334
1486 523 263 142 88 1107 57 123 55 52 110 90
370 253 279 88 172 20 20 1241 655 106 419 473
619 455 407 142 147 1 1 678 299 102 546 699
485 348 403 129 176 1 1 587 260 129 975 602
212 176 147 103 71 1 1 1730 338 29 736 552
783 262 317 133 144 726 36 154 72 56 361 1052
135 86 161 40 136 1 1 462 165 77 2278 554
103 81 147 72 212 1 1 424 186 122 1872 875
176 127 91 85 47 1 1 587 262 53 1549 1117
191 167 162 112 143 1 1 1177 341 66 1004 731
52 44 9 15 18 98 6 1246 420 586 819 783
546 199 167 109 86 1849 44 124 106 42 326 498
15 15 13 14 15 1 1217 203 68 1 1297 1237
32 28 23 20 18 1 128 2227 351 6 670 592
25 32 28 19 15 2 371 125 3 2 2250 1224
1041 567 396 86 92 22 23 912 109 45 380 423
396 151 350 30 111 11 11 1387 303 69 396 881
299 179 255 81 122 4 4 1652 353 70 415 662
766 497 452 147 122 4 4 501 304 79 526 694
1007 740 484 222 115 29 31 638 53 39 383 355
379 187 280 145 104 6 6 1640 359 75 384 531
317 316 183 125 67 36 6 1082 796 193 486 489
173 109 113 61 61 1 1 517 204 50 1393 1413
855 455 423 133 124 1 1 851 140 35 502 576
431 332 245 125 88 1 1 1051 253 73 573 923
960 348 244 94 128 1607 55 224 60 49 146 181
403 134 294 52 63 1581 52 426 215 40 291 545
1039 489 363 90 94 22 24 997 204 58 306 410
1972 179 202 38 37 31 34 951 79 31 146 396
311 152 94 30 32 17 17 1978 230 52 307 876
1427 456 301 75 45 29 30 811 192 109 244 377
321 175 166 90 26 10 10 1691 332 51 443 781
903 472 523 96 86 11 11 542 314 65 390 683
721 352 318 79 68 1 1 832 210 54 449 1011
1879 354 325 88 73 29 55 535 71 29 321 337
1046 587 506 194 73 28 49 800 93 40 354 326
926 421 444 99 47 18 20 1082 217 59 317 446
318 256 144 62 82 7 7 1743 294 77 454 652
326 382 216 213 38 18 18 1146 437 81 526 695
171 108 106 53 33 1 1 537 178 68 2486 354
165 136 96 73 41 1 1 521 181 85 2343 453
242 144 141 66 76 1 1 1511 349 43 723 799
379 125 102 62 64 2882 55 170 53 52 66 86
1 1 1 1 1 1 3127 49 1 1 668 244
47 36 30 18 7 2 347 431 2 2 1243 1931
780 111 97 40 27 21 624 29 21 21 2039 286
27 21 21 40 10 7 159 18 7 7 3409 370
269 240 228 135 37 9 9 1622 473 108 449 517
1295 519 523 100 112 27 31 916 49 49 204 271
302 210 98 97 140 22 22 1769 317 110 501 508
405 240 262 122 118 14 14 1391 365 80 394 691
635 653 236 251 71 2 2 676 255 77 530 708
288 235 211 321 71 9 9 874 527 242 546 763
144 178 67 142 31 1 1 724 343 110 1921 434
136 134 73 113 43 1 4 469 271 143 1610 1099
484 187 296 68 58 20 476 38 20 20 1909 520
38 47 36 50 22 1 270 119 1 1 2095 1416
371 276 291 172 168 2 2 823 277 97 890 727
114 173 62 210 36 1 1 509 165 109 2051 665
65 59 89 37 72 1 1 1223 652 151 865 881
148 90 104 56 65 1 1 486 219 101 1369 1456
489 187 476 50 251 1 1 925 229 91 592 804
213 107 122 65 29 2 2 1060 143 11 1316 1026
151 104 63 64 40 3 1 1594 425 91 894 666
463 632 166 415 39 1 1 697 197 97 713 675
45 28 31 25 21 1 1 278 100 33 1035 2498
50 32 32 20 19 1 5 283 164 123 1646 1721
37 24 24 16 15 1 6 250 147 137 1734 1705
76 30 7 54 30 76 4 374 203 98 1626 1518
46 28 29 19 19 1 44 333 139 1 1727 1710
14 12 9 7 8 1 393 320 190 1 2025 1116
20 18 15 15 12 1 2 1875 503 190 717 728
12 9 8 8 6 1 6 1507 494 315 876 854
25 20 19 18 17 1 253 1105 316 1 1385 936
413 86 160 80 139 1527 46 227 85 62 701 570
26 17 15 9 7 1 897 43 1 1 1662 1417
13 10 11 6 5 1 1157 74 1 1 1591 1226
782 398 381 101 113 2 2 793 105 17 474 928
59 51 49 44 41 1 1 1129 344 229 1024 1124
44 38 37 33 31 1 3 1062 349 271 1047 1180
107 91 79 58 52 1 1 1658 316 41 609 1083
45 38 35 28 29 1 1 2242 343 221 518 595
34 28 26 21 22 1 3 2209 364 306 503 579
592 356 212 130 95 1906 53 158 56 49 366 123
45 45 45 42 51 17 7 349 465 126 1541 1363
24 17 24 17 23 107 17 1274 558 432 714 889
160 98 99 56 59 3228 54 85 53 52 64 88
238 184 190 92 89 2790 55 111 57 53 108 129
120 82 86 62 75 2351 49 499 385 51 193 143
102 77 76 56 57 3363 53 62 53 52 63 82
158 102 74 53 50 2052 731 46 42 42 462 284
9 9 9 9 9 9 3444 9 9 9 479 92
1 1 1 1 1 1 4036 1 1 1 29 22
31 22 37 77 133 41 97 139 93 70 190 112 201 326 780 1747
103 77 178 563 912 164 430 725 135 37 461 183 42 32 26 28
222 121 310 476 755 240 495 619 175 46 292 194 40 29 46 36
348 174 451 474 728 362 430 613 128 29 155 155 19 10 11 9
367 190 431 422 673 320 446 621 182 39 169 161 26 22 13 14
472 291 395 309 525 355 509 512 201 58 182 157 41 34 29 26
462 318 479 285 426 318 503 405 296 93 169 167 61 61 29 24
359 244 357 279 440 351 534 607 279 101 180 162 68 60 44 31
210 215 398 339 513 308 580 318 339 150 225 207 120 93 49 32
219 161 267 288 573 381 492 454 324 142 246 186 183 82 57 41
96 93 204 222 478 411 617 380 397 204 280 235 254 124 65 36
91 67 120 118 232 222 385 543 494 301 688 273 291 130 91 50
44 37 77 85 180 187 389 652 614 382 503 240 421 169 81 35
69 45 72 76 132 124 224 537 639 293 877 370 276 157 130 75
19 14 28 37 78 86 179 494 950 327 629 536 508 103 74 34
25 16 31 44 90 91 217 817 478 478 799 399 276 164 130 41
22 16 26 25 46 58 88 112 274 193 511 307 516 711 842 349
8 7 15 16 32 44 76 158 407 459 384 305 798 617 620 150
3 3 6 7 13 16 33 49 150 132 212 239 509 906 1375 443
1 4 5 6 12 10 25 33 82 76 168 357 1372 1492 340 113
106 200 218 461 352 466 394 490 268 311 314 284 141 61 23 7
123 230 203 303 250 394 323 476 298 374 411 310 195 123 62 21
138 221 182 270 194 311 266 433 355 505 559 380 178 72 24 8
# Set 2: the frequencies of each cluster, which sum to 4096.
1 4095
2383 1713
3384 68 1 588 4 1 1 27 21 1
3784 91 10 200 1 1 1 6 1 1
1578 2230 1 270 1 1 1 12 1 1
2034 1949 1 105 1 2 1 1 1 1
2429 1454 61 101 24 6 1 9 10 1
715 3373 1 1 1 1 1 1 1 1
1411 224 2410 45 1 1 1 1 1 1
536 770 1 1235 1 1 1 1549 1 1
2115 27 1 1781 19 15 1 71 59 7
993 461 1 2074 80 65 10 79 293 40
2340 9 1 815 667 55 1 117 75 16
940 40 1 2570 1 85 1 23 434 1
335 7 1 1012 21 1234 39 31 1390 26
576 5 1 3055 39 40 11 96 146 127
163 3914 1 10 1 1 1 3 1 1
58 4025 2 2 4 1 1 1 1 1
10 4078 1 1 1 1 1 1 1 1
1339 1246 1 1215 199 19 5 32 34 6
495 18 1 1279 1961 5 1 325 10 1
114 3792 4 133 1 1 1 48 1 1
5 6 1 247 48 1323 101 17 2280 68
298 78 1 2896 61 1 5 284 113 359
196 1 1 2678 601 83 13 307 161 55
11 21 1 530 5 97 16 328 193 2894
790 14 1 2508 155 1 1 588 37 1
14 1 1 46 3987 1 18 26 1 1
43 11 1 149 3624 1 1 264 1 1
18 1 1 358 356 2653 227 18 452 12
50 1 1 199 1 3112 57 1 673 1
44 1 1 130 1536 15 2173 180 8 8
70 8 1 246 1952 124 1 1630 56 8
39 1 1 258 593 1224 294 195 1434 57
89 1 1 538 565 648 232 278 1043 701
1 42 1 187 25 247 10 581 172 2830
104 32 1 1024 1184 1 1 1743 5 1
11 5 1 114 247 721 2519 32 238 208
38 1 1 129 237 92 3587 1 1 9
22 1 1 125 3485 88 254 72 18 30
177 3863 8 18 1 19 1 1 7 1
83 33 1 476 1 1084 1 5 2411 1
1177 302 1228 2 296 1070 21
395 313 228 46 1060 846 1208
2763 395 3 1 653 227 54
1624 790 2 1 1662 16 1
677 377 1 1 3026 13 1
2191 200 1 3 1145 278 278
1928 11 381 1 174 1436 165
1826 4 188 81 709 1252 36
1290 1 1086 1 1 1716 1
677 1 199 1 1 3216 1
3354 1 1 1 687 46 6
2392 1 1 1 278 1368 55
1761 2 671 1 94 1538 29
1998 3 1 1 1781 254 58
2452 1 6 1 638 853 145
2780 30 28 1 565 478 214
218 1110 1177 159 334 52 606 20 169 13 52 33 54 74 25
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
251 1116 966 518 954 111 113 18 14 6 4 17 6 1 1
2349 308 711 87 244 45 193 10 43 14 17 31 33 1 10
3301 69 156 30 176 35 89 16 41 11 10 58 40 50 14
1516 368 1198 108 500 57 182 17 47 11 18 31 29 6 8
190 679 555 372 605 139 481 52 302 51 308 141 156 46 19
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
33 185 220 1465 1462 203 335 40 41 37 52 3 18 1 1
1846 17 26 284 840 66 158 61 221 61 162 165 160 18 11
2379 13 18 133 706 16 52 23 494 23 112 42 51 29 5
1864 50 45 277 708 87 183 58 171 61 155 183 174 50 30
1043 308 1498 136 627 12 5 98 10 1 125 233
500 205 1146 142 1031 12 3 164 44 9 292 548
168 502 82 775 73 661 88 191 39 15 1276 226
1238 816 262 307 65 1177 1 34 14 1 132 49
1464 590 798 236 337 1 5 226 24 4 189 222
1294 1006 510 438 158 66 3 111 31 1 346 132
973 731 628 435 270 11 3 171 74 13 479 308
785 1023 215 776 77 21 2 294 64 5 708 126
451 475 272 387 221 584 1 159 68 53 772 653
512 256 779 181 521 9 7 248 111 41 686 745
157 291 98 599 97 6 9 331 174 65 1809 460
181 560 109 1092 78 16 9 177 75 7 1522 270
454 313 259 206 150 7 6 1113 293 47 792 456
217 59 40 70 45 988 2 765 149 111 1222 428
244 287 107 293 40 2232 4 150 139 16 481 103
114 74 68 161 74 31 686 257 17 1 1813 800
257 105 93 105 86 1 20 1665 227 39 882 616
874 635 597 88 290 15 852 19 1 1 353 371
2340 799 685 60 72 1 2 47 2 1 38 49
1612 695 1268 83 268 10 4 22 2 1 60 71
1892 1027 772 110 128 54 2 23 3 1 47 37
1629 719 567 169 105 1 1 277 96 1 315 216
1409 754 1224 452 64 1 3 36 5 1 100 47
1091 1836 300 670 30 31 1 15 4 1 96 21
1476 833 737 420 227 9 5 62 19 3 205 100
214 229 185 525 256 19 7 183 137 69 1261 1011
1637 343 260 92 67 3 4 1080 82 5 272 251
1329 708 531 197 149 3 3 518 50 8 279 321
1281 314 142 153 35 1667 1 233 84 2 100 84
433 94 60 33 23 2997 17 154 44 10 152 79
1978 1124 699 36 133 1 3 37 3 1 32 49
3666 196 153 7 4 1 2 24 1 1 16 25
2991 680 203 26 7 119 1 21 1 1 10 36
2723 699 492 47 28 1 1 40 4 1 33 27
1806 1699 330 135 22 38 1 16 1 1 30 17
2621 270 198 45 29 1 1 477 86 1 187 180
2510 410 209 100 28 106 1 467 45 1 105 114
3338 321 255 16 10 1 33 24 1 1 42 54
1249 1604 419 627 35 2 9 17 2 1 102 29
2021 911 828 170 30 1 3 37 3 1 62 29
1666 1741 212 368 15 22 1 9 1 1 50 10
646 1748 134 1117 47 2 6 59 5 1 283 48
1410 323 304 161 132 1 8 446 136 46 609 520
690 601 338 455 137 34 6 264 108 43 1059 361
1645 220 174 73 67 19 2 936 187 36 397 340
178 41 22 8 2 3797 1 12 1 1 10 23
265 76 58 45 24 8 2656 32 1 1 514 416
1047 176 159 122 65 11 868 304 34 1 670 639
2286 213 167 48 27 1 1097 1 1 1 134 120
1633 573 149 137 17 612 719 1 1 1 128 125
1321 1399 665 145 337 4 3 40 5 1 71 105
2418 680 706 73 41 1 6 74 3 1 60 33
2262 1000 528 156 31 12 1 25 3 1 54 23
394 2342 29 1251 4 12 1 2 1 1 57 2
317 1930 32 1349 10 19 1 31 5 1 386 15
104 1225 28 2291 14 8 1 5 2 1 410 7
179 816 65 1760 27 23 1 43 24 2 1108 48
36 238 21 1591 13 22 3 56 47 3 2025 41
1322 618 574 251 40 1 797 8 1 1 313 170
326 1077 89 1215 16 56 444 19 1 1 754 98
1035 906 397 496 198 3 5 339 35 2 450 230
44 126 25 641 18 39 1 139 79 13 2888 83
272 203 538 157 932 19 8 165 106 30 479 1187
411 246 236 231 236 2 7 420 258 43 983 1023
513 272 545 179 437 10 9 455 115 25 632 904
607 192 188 195 185 1 6 838 23 4 984 873
407 486 238 371 122 107 2 492 60 6 1438 367
459 518 246 480 175 2 8 528 88 16 925 651
84 164 84 1182 100 40 1 70 57 30 1844 440
84 69 65 139 87 1 9 320 214 125 2181 802
24 25 18 139 15 31 1 133 87 50 3403 170
37 44 40 142 36 519 1 184 149 62 2394 488
91 91 84 194 137 1 55 286 140 1 2006 1010
39 38 26 172 29 24 235 184 74 1 3012 262
92 67 61 80 64 8 7 1055 461 164 1374 663
22 21 19 32 21 37 1 934 377 165 2146 321
302 115 119 125 98 3 70 443 200 1 1449 1171
18 22 20 43 15 1976 3 103 67 21 1571 237
279 118 104 156 135 1 860 21 1 1 1399 1021
33 29 17 73 17 86 1493 49 1 1 2003 294
2706 235 209 33 35 1 1 611 9 1 107 148
255 137 117 126 97 1 7 584 291 180 1279 1022
111 103 80 174 71 29 1 500 129 327 1709 862
468 372 287 274 191 11 4 1005 261 85 564 574
238 98 83 83 69 1 5 1381 379 140 839 780
66 46 36 48 47 47 1 1143 437 320 907 998
373 291 140 83 36 2869 1 99 32 1 102 69
65 57 41 85 33 1934 6 252 285 248 873 217
87 46 30 41 20 1911 2 787 237 147 512 276
56 8 7 1 1 3974 1 4 1 1 2 40
86 62 42 83 13 3563 2 75 12 6 53 99
59 16 7 7 4 2961 4 661 281 4 51 41
5 1 1 1 1 4040 1 1 1 1 2 41
36 6 3 3 1 3274 626 1 1 1 28 116
242 15 11 15 5 51 3540 1 1 1 172 42
1 1 1 1 1 3 4019 1 1 1 21 45
526 261 356 214 243 166 231 180 287 229 250 132 123 152 436 310
1280 436 472 272 254 143 176 133 185 152 152 79 61 79 142 80
1477 670 667 309 276 127 143 76 102 64 61 31 25 18 30 20
2100 563 538 245 203 81 69 47 70 42 43 22 14 17 25 17
3133 486 178 75 67 31 30 17 21 15 16 6 5 6 6 4
1110 793 1017 433 296 112 108 49 55 35 37 14 8 9 12 8
1277 1209 1196 236 75 25 26 12 13 9 6 3 2 2 3 2
439 399 803 695 839 349 255 95 77 46 41 15 12 10 12 9
199 397 1068 1008 1018 216 77 33 27 18 14 6 3 3 6 3
239 227 485 461 800 569 598 236 216 106 80 24 17 12 14 12
74 79 335 702 1265 760 528 130 95 39 31 15 9 7 15 12
153 142 300 373 685 508 696 393 406 182 139 49 27 13 12 18
61 56 166 228 658 583 900 476 479 199 163 40 15 14 10 48
339 267 364 283 430 325 401 279 383 416 359 111 60 24 10 45
103 89 197 220 392 338 415 291 460 527 803 118 46 33 14 50
46 39 115 109 244 167 224 148 613 1447 741 90 38 13 17 45
312 265 425 372 513 391 461 310 331 225 229 96 82 33 29 22
113 137 143 159 432 546 637 234 464 502 474 89 94 26 11 35
104 130 176 165 239 173 300 175 305 584 720 292 527 129 46 31
28 29 29 29 346 31 34 35 46 962 247 142 1146 770 146 76
1745 826 367 379 199 209 111 100 51 55 35 12 4 1 1 1
1073 920 468 475 255 283 171 168 89 125 54 10 2 1 1 1
1298 1068 482 434 224 229 121 122 60 36 15 3 1 1 1 1
# Set 3: the frequencies of each cluster, which sum to 4096.
3138 958
3266 830
4039 44 1 6 1 1 1 1 1 1
4054 1 24 11 1 1 1 1 1 1
1928 2160 1 1 1 1 1 1 1 1
1928 2152 2 2 2 2 2 2 2 2
3413 7 664 6 1 1 1 1 1 1
834 3254 1 1 1 1 1 1 1 1
2770 1 1318 1 1 1 1 1 1 1
762 3302 4 4 4 4 4 4 4 4
3267 3 3 805 3 3 3 3 3 3
1836 787 37 592 68 115 52 155 340 114
1655 72 53 1130 487 124 77 261 148 89
1237 74 39 2096 36 109 38 59 355 53
340 63 53 1216 84 1070 118 102 896 154
715 41 34 2782 61 57 42 108 129 127
48 4040 1 1 1 1 1 1 1 1
2452 7 1623 2 2 2 2 2 2 2
13 4075 1 1 1 1 1 1 1 1
1813 842 69 979 88 77 46 64 63 55
412 76 53 1222 1641 67 78 392 80 75
3981 6 67 6 6 6 6 6 6 6
82 103 53 238 163 1686 176 99 1306 190
358 415 54 1339 220 79 94 698 259 580
267 65 53 1991 635 143 117 448 171 206
116 181 53 1053 90 297 88 201 806 1211
1234 74 48 1832 139 42 43 551 77 56
59 53 53 93 3499 56 65 112 53 53
65 64 53 135 3170 54 53 395 53 54
61 53 53 181 277 2827 170 92 305 77
69 53 53 161 55 3005 111 54 480 55
67 53 53 112 1185 147 2112 184 107 76
75 76 53 273 1701 199 229 1156 120 214
82 53 53 258 522 1511 325 522 618 152
115 54 53 487 684 760 308 471 694 470
65 243 53 257 344 396 103 418 646 1571
125 109 53 484 1242 53 54 1859 57 60
65 75 53 133 259 1037 1895 139 329 111
68 53 53 94 160 176 3224 66 131 71
87 53 53 138 2835 188 312 211 82 137
3103 12 897 12 12 12 12 12 12 12
96 156 53 418 53 1083 53 63 2063 58
1337 641 845 70 525 562 116
2235 18 18 18 940 203 664
2735 330 56 63 610 177 125
1916 795 52 56 1158 62 57
2524 284 48 56 1081 54 49
2510 44 7 7 889 191 448
2622 7 7 7 114 759 580
1786 341 297 248 419 384 621
1687 56 1039 55 63 1137 59
1500 43 425 44 42 1996 46
3644 51 43 50 169 87 52
2472 34 114 33 80 1292 71
1932 52 421 63 134 1371 123
2692 90 31 31 1106 84 62
2587 40 33 32 266 641 497
2755 3 3 3 427 580 325
196 970 1402 181 415 93 260 61 112 59 68 90 63 72 54
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
261 1238 1273 366 365 92 89 53 54 53 50 52 50 50 50
2122 315 694 115 216 77 116 56 66 54 55 54 55 50 51
2688 143 448 88 132 64 80 55 62 53 52 66 58 56 51
1389 449 1021 160 378 91 148 58 83 55 53 54 55 51 51
44 244 124 84 224 345 325 425 204 546 485 265 773 4 4
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
819 398 302 758 695 179 223 80 82 63 294 49 65 45 44
409 125 4 470 348 125 186 287 490 267 429 287 641 4 24
1302 74 120 452 447 34 65 247 740 136 258 142 32 25 22
541 71 138 250 407 429 340 183 94 250 340 384 572 26 71
766 361 1018 181 592 81 1 134 18 1 549 394
404 195 735 146 768 99 1 127 37 5 701 878
228 161 306 131 368 1359 38 266 48 13 536 642
939 614 539 191 134 1198 1 63 14 1 223 179
1220 769 645 272 218 1 1 186 23 2 475 284
1084 734 686 335 268 131 1 101 28 2 441 285
790 545 831 314 474 80 1 81 29 6 565 380
733 548 507 369 282 117 1 365 38 7 676 453
461 200 539 117 227 1203 1 132 49 13 815 339
500 311 573 196 322 91 1 103 55 29 1335 580
244 195 338 218 372 106 2 210 100 50 1468 793
432 426 375 426 276 78 12 242 74 10 1158 587
339 222 255 168 167 106 5 795 215 71 1160 593
211 130 197 91 145 1235 1 579 187 71 688 561
398 261 310 129 222 1883 1 118 34 6 374 360
70 81 71 86 57 43 1405 168 42 1 1281 791
171 125 189 109 151 9 113 1260 273 28 1058 610
439 338 327 215 252 168 570 27 2 1 1225 532
1392 743 1106 213 190 1 1 66 7 1 197 179
1137 608 1110 239 351 99 1 71 8 1 214 257
1278 821 869 304 236 145 1 56 6 1 170 209
1282 661 935 287 253 1 1 62 40 2 373 199
1064 686 1235 294 251 1 1 52 8 1 391 112
1096 853 912 396 217 138 1 42 7 1 316 117
859 718 885 449 344 61 1 31 8 1 543 196
331 267 444 226 434 105 8 225 97 39 934 986
1058 612 666 269 168 122 3 288 58 5 468 379
1035 554 711 239 210 129 1 372 40 10 482 313
865 270 743 71 205 1454 1 64 19 1 265 138
557 139 716 65 197 1369 1 188 62 16 519 267
1424 840 841 328 213 1 1 49 5 1 155 238
1648 916 779 313 59 1 1 40 4 1 119 215
1489 959 703 336 97 163 1 42 4 1 114 187
1670 823 836 278 104 1 1 53 5 1 149 175
1422 880 792 341 126 180 1 47 5 1 152 149
1543 720 877 283 151 1 1 53 41 1 257 168
1175 711 746 316 184 220 1 132 33 2 356 220
1676 834 810 302 86 1 1 34 1 1 169 181
1193 965 656 482 180 37 1 38 5 1 331 207
1465 830 912 305 165 1 1 39 5 1 229 143
1317 920 726 394 183 143 1 39 6 1 231 135
736 952 376 691 201 55 1 151 11 1 598 323
877 576 513 314 174 1 1 111 55 18 847 609
637 539 412 372 189 98 1 108 55 37 1064 584
569 370 387 218 154 127 1 630 148 61 871 560
793 294 619 81 149 1637 1 77 18 2 283 142
16 15 11 12 14 3 3136 31 1 1 615 241
455 324 289 188 77 82 1062 184 9 1 914 511
932 653 566 294 103 2 335 20 2 2 806 381
617 563 375 342 108 221 531 20 1 1 1002 315
1113 800 566 306 591 114 1 39 5 1 208 352
1519 885 690 371 150 1 1 40 5 1 209 224
1355 963 627 416 145 156 1 38 7 1 201 186
971 1098 532 646 159 112 1 32 6 1 394 144
717 825 410 634 194 87 1 153 20 2 734 319
563 940 276 1052 170 44 1 50 9 4 812 175
519 655 335 617 200 89 1 117 37 15 1040 471
290 346 284 489 269 74 11 204 89 28 1523 489
1104 646 640 319 82 1 324 22 1 1 700 256
513 423 367 335 124 165 681 53 1 1 1126 307
400 325 344 231 560 81 1 522 26 3 562 1041
148 227 124 380 167 70 1 260 125 64 1992 538
289 247 433 254 743 149 2 130 54 23 485 1287
263 207 544 153 847 119 3 178 82 30 633 1037
502 330 550 255 458 112 1 384 65 17 726 696
663 399 646 286 363 1 1 546 34 6 603 548
605 430 559 351 346 127 2 361 54 8 749 504
634 456 603 341 284 55 5 352 79 24 755 508
192 212 237 263 347 121 6 126 84 49 1381 1078
105 112 152 131 231 1 11 231 163 130 1850 979
85 91 104 121 130 73 16 225 156 136 2100 859
101 83 205 87 332 1259 1 207 115 63 853 790
108 120 165 141 251 1 84 217 136 1 1811 1061
64 71 64 85 72 37 570 270 170 1 2119 573
145 110 162 109 137 115 3 1052 305 121 1177 660
56 50 60 55 59 80 13 864 429 265 1495 670
95 101 100 79 84 30 425 567 312 1 1672 630
156 96 278 90 311 1451 1 316 83 37 571 706
91 81 155 87 247 1 1069 38 1 1 1426 899
57 60 97 71 141 104 1366 62 1 1 1477 659
1396 607 850 191 125 1 1 331 27 6 323 238
194 177 189 147 137 1 3 489 229 219 1348 963
155 148 142 134 115 82 7 478 180 308 1445 902
393 278 310 210 175 135 5 970 209 76 731 604
152 110 130 82 98 1 2 1055 383 295 965 823
101 85 92 79 69 95 11 1122 334 324 1013 771
622 432 271 149 120 1963 1 126 16 1 175 220
138 116 126 108 141 1971 1 110 73 36 707 569
192 125 99 69 67 2066 1 501 159 50 414 353
540 185 473 39 127 2259 1 114 15 1 183 159
422 168 348 68 146 2196 1 104 22 8 308 305
178 99 189 68 171 2281 1 138 71 27 454 419
336 165 290 90 146 2074 1 140 48 18 425 363
239 111 259 78 158 1857 209 41 5 1 610 528
7 11 17 14 14 20 3572 1 1 1 364 74
1 1 1 1 1 1 4038 1 1 1 29 20
658 544 1123 248 205 128 172 110 147 110 128 68 95 105 176 79
1276 809 1488 220 111 46 39 20 20 15 12 6 8 8 14 4
1374 827 1123 296 196 81 68 30 32 19 15 8 7 7 10 3
1822 885 913 206 135 46 35 12 12 8 7 3 3 3 5 1
2013 947 700 168 112 50 43 14 15 9 9 4 3 3 4 2
1257 829 1104 435 229 82 63 26 24 14 12 5 4 4 6 2
1208 964 1199 380 182 53 46 19 17 9 8 3 2 2 3 1
530 461 858 676 788 330 221 76 65 30 25 11 8 8 7 2
329 369 897 868 1020 326 151 47 39 18 14 6 4 4 3 1
257 242 492 460 783 588 654 252 173 67 54 23 19 15 12 5
113 123 310 439 973 810 827 243 131 46 36 14 12 9 8 2
190 164 313 275 546 488 726 470 474 184 135 49 32 20 23 7
83 90 179 178 407 537 1004 621 585 180 121 42 25 19 20 5
321 220 316 226 380 290 438 340 514 343 364 155 96 39 27 27
106 97 174 158 311 287 471 389 638 529 569 191 100 35 28 13
83 51 93 86 147 146 320 345 720 750 899 268 124 35 18 11
309 241 387 296 456 378 554 327 379 194 232 129 100 60 40 14
172 123 164 166 300 274 493 307 450 292 548 342 274 130 38 23
85 57 78 102 142 119 248 218 388 310 811 599 644 229 46 20
38 23 15 48 15 15 90 90 32 23 40 239 2411 987 15 15
1631 941 413 408 207 196 99 95 44 34 18 6 1 1 1 1
1245 959 482 472 232 244 133 141 71 64 37 11 2 1 1 1
1336 1109 531 484 199 175 88 83 35 30 16 6 1 1 1 1
# Set 4: the frequencies of each cluster, which sum to 4096.
1 4095
2410 1686
2781 132 1 1017 14 2 1 105 37 6
1773 292 40 1912 17 12 1 29 16 4
811 2654 5 552 1 4 1 37 4 27
1837 2020 1 228 1 1 1 2 4 1
1900 1524 84 505 53 17 1 1 10 1
523 3496 1 70 1 1 1 1 1 1
1120 245 2348 377 1 1 1 1 1 1
286 681 230 734 1 1 1 2160 1 1
1643 53 2 2158 29 17 1 101 68 24
921 966 7 1374 14 98 20 113 561 22
1988 5 1 1200 529 79 3 202 55 34
566 54 1 2882 1 75 1 2 506 8
285 6 1 1327 19 1305 41 38 996 78
485 8 1 3110 35 37 6 110 159 145
159 3906 1 12 1 1 1 13 1 1
62 4015 3 5 6 1 1 1 1 1
11 4077 1 1 1 1 1 1 1 1
1778 998 13 1152 102 13 1 8 29 2
465 22 1 1300 2032 13 3 210 32 18
25 3512 3 41 6 63 1 124 113 208
17 13 1 222 143 2009 108 45 1337 201
265 130 1 1831 123 15 9 683 330 709
228 2 1 2481 608 71 51 349 174 131
17 63 1 1215 27 215 4 188 676 1690
546 50 3 2398 122 1 1 950 17 8
10 1 1 53 3981 6 9 33 1 1
26 11 1 115 3562 1 1 377 1 1
6 1 1 187 241 3008 210 35 377 30
12 1 1 117 3 3289 63 1 608 1
10 1 1 59 1491 173 2126 122 64 49
58 9 1 312 1552 299 226 1228 78 333
32 1 1 276 420 1755 332 112 1054 113
54 1 1 478 619 884 275 311 839 634
11 52 1 161 485 338 80 599 346 2023
47 32 1 627 1151 1 1 2229 1 6
21 1 1 60 190 1275 1925 57 484 82
35 1 1 32 208 149 3547 1 38 84
30 1 1 84 3182 128 370 217 77 6
175 3795 10 75 1 29 1 1 8 1
81 37 1 456 1 1394 1 3 2121 1
1214 367 1367 16 180 841 111
384 358 248 30 135 156 2785
2560 472 31 23 633 262 115
1616 832 1 1 1626 15 5
2163 471 1 1 1450 5 5
2281 235 20 10 927 194 429
2286 24 235 18 113 991 429
2171 108 112 111 633 530 431
1652 1 1235 1 1 1204 2
910 1 396 1 1 2786 1
3773 12 1 1 265 43 1
2285 1 84 1 13 1699 13
1942 22 748 22 167 1094 101
2203 101 1 1 1699 36 55
2362 37 24 5 771 646 251
2396 51 32 12 579 632 394
184 1006 1542 153 450 67 348 23 167 21 48 15 6 60 6
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
226 1477 1517 468 320 49 17 5 3 9 1 1 1 1 1
2256 324 886 105 261 58 115 17 39 9 11 4 9 1 1
3223 114 381 50 111 22 76 14 20 4 4 51 20 5 1
1670 401 1033 172 485 56 150 10 97 7 5 2 6 1 1
128 382 487 307 928 97 1174 33 374 29 77 63 11 5 1
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
42 406 434 2070 580 270 79 89 55 39 28 1 1 1 1
1668 27 28 216 1614 73 197 34 127 27 30 44 9 1 1
2344 7 12 171 1227 25 118 25 67 17 21 45 15 1 1
1474 30 40 193 1713 71 223 40 145 37 37 81 10 1 1
1668 669 1117 143 204 42 6 33 9 1 106 98
1104 592 1074 253 351 31 13 112 21 2 256 287
420 560 187 307 142 1422 182 187 90 4 424 171
1530 986 181 180 20 1027 3 52 5 1 91 20
1747 891 446 405 114 1 11 107 19 1 244 110
1740 1526 211 232 25 125 1 87 34 10 66 39
1242 649 578 292 255 23 14 262 57 5 400 319
1089 744 292 352 139 100 12 617 40 4 509 198
865 732 496 330 315 670 1 127 53 10 162 335
1261 655 481 199 221 38 15 352 73 6 346 449
699 476 297 221 213 20 10 419 209 19 822 691
696 531 382 390 324 79 65 411 67 3 615 533
1040 473 327 259 138 14 4 941 119 15 479 287
601 110 218 51 130 1516 1 894 29 14 180 352
448 524 110 275 24 2213 6 175 50 4 227 40
510 158 201 137 314 120 489 236 14 1 324 1592
1154 219 288 111 159 5 44 1195 123 11 395 392
1088 1072 312 188 80 45 988 11 1 1 174 136
2503 792 456 82 48 1 5 72 2 1 66 68
2311 531 874 78 109 44 6 28 2 1 52 60
2249 996 460 49 42 199 4 47 1 1 22 26
1900 632 459 141 82 1 8 337 42 1 295 198
1473 1047 766 416 71 1 15 67 7 1 150 82
1387 2097 132 270 9 115 1 32 1 1 41 10
1565 576 817 168 457 36 15 112 11 1 110 228
735 359 471 188 487 78 17 351 134 38 274 964
1935 265 191 65 43 10 4 1178 31 1 188 185
1674 483 495 59 191 21 5 646 37 3 181 301
1192 510 137 94 29 1798 3 230 11 1 44 47
675 245 97 46 36 2633 33 208 20 1 25 77
2253 683 800 48 111 1 8 62 3 1 54 72
3681 151 114 8 9 1 3 55 1 1 33 39
3116 584 88 13 3 174 1 52 1 1 26 37
2681 715 423 57 41 1 5 56 3 1 61 52
1761 2008 102 50 3 108 1 27 1 1 19 15
2789 220 153 34 30 1 2 475 34 1 178 179
2490 449 220 31 65 144 1 538 8 1 41 108
3368 267 207 17 15 1 44 43 1 1 62 70
1960 1197 345 225 57 12 55 30 2 1 169 43
2180 881 616 127 53 1 14 72 3 1 99 49
2384 1291 120 105 16 92 3 26 1 1 47 10
1407 1235 417 364 151 37 106 64 6 1 206 102
1854 323 231 132 111 1 11 628 60 3 300 442
1014 596 296 299 229 75 20 411 135 52 319 650
2429 194 205 37 55 32 2 681 70 9 166 216
345 135 32 25 5 3393 1 123 2 1 10 24
827 203 181 67 80 17 2316 13 1 1 208 182
1725 303 349 97 149 12 530 260 1 1 259 410
2164 218 146 30 18 1 1329 2 1 1 99 87
1278 787 62 222 4 536 1034 2 1 1 101 68
1511 929 804 79 467 26 10 78 6 1 82 103
2491 424 770 59 69 1 17 110 2 1 96 56
2702 674 356 72 38 62 8 62 1 1 94 26
1352 2006 36 497 9 100 5 8 1 1 77 4
888 1232 78 617 13 217 21 405 18 1 515 91
758 1428 313 765 181 82 99 19 2 1 343 105
696 1181 272 548 179 147 6 192 77 3 602 193
256 484 64 408 43 194 159 345 141 1 1794 207
1126 445 526 153 57 1 1463 8 1 1 233 82
525 764 147 414 48 145 1447 24 1 1 509 71
1365 502 698 145 422 7 17 324 18 1 235 362
25 699 46 589 106 126 3 367 445 24 1311 355
723 299 587 139 938 24 9 263 100 2 215 797
1646 339 369 123 193 1 8 486 113 6 365 447
1050 380 530 143 316 37 16 563 125 11 286 639
1795 248 274 90 154 1 8 838 14 1 263 410
683 267 292 32 699 151 1 699 9 1 81 1181
1229 395 462 191 252 3 21 569 66 6 370 532
163 101 274 34 1231 93 1 66 31 5 164 1933
514 181 195 136 197 1 8 526 218 51 508 1561
41 29 36 13 200 30 1 173 137 17 264 3155
240 57 431 41 483 715 1 82 236 27 598 1185
763 233 236 117 282 1 50 397 87 1 459 1470
38 5 73 15 227 26 79 60 31 1 1746 1795
591 232 238 83 165 36 2 1285 167 60 441 796
132 32 36 17 40 21 2 1283 116 90 195 2132
1571 270 282 108 211 16 27 495 138 1 285 692
186 49 249 63 247 2182 2 180 45 2 385 506
1286 227 339 135 192 1 888 15 1 1 483 528
121 55 122 36 250 139 2237 64 1 1 547 523
2614 154 168 18 29 1 2 868 6 1 96 139
1058 237 188 100 128 1 6 883 264 129 328 774
94 44 82 12 126 89 1 609 115 292 45 2587
824 392 750 111 503 68 1 686 106 9 202 444
1262 198 171 56 81 1 4 1081 231 59 351 601
131 17 32 25 71 143 1 1534 172 138 55 1777
691 534 126 147 25 2201 7 251 10 1 40 63
183 100 162 49 119 1964 2 492 187 432 111 295
363 196 123 87 79 1966 2 650 88 37 242 263
121 53 32 5 3 3791 1 33 1 1 5 50
242 303 142 101 32 2986 7 189 11 1 25 57
94 25 11 13 5 2799 3 1003 77 1 20 45
22 14 9 4 1 3995 1 4 1 1 2 42
105 56 17 30 5 3077 669 5 1 1 25 105
267 87 63 65 29 64 3363 1 1 1 128 27
1 1 1 1 1 4 4026 1 1 1 17 41
804 445 775 411 371 147 171 119 185 127 266 118 141 14 1 1
1222 538 754 412 388 148 145 82 96 65 125 60 47 12 1 1
2023 616 618 311 241 94 71 22 23 20 23 19 12 1 1 1
1972 665 578 279 224 65 72 29 35 40 70 37 25 3 1 1
2490 519 467 194 184 50 44 19 27 25 39 26 9 1 1 1
1227 846 1139 440 256 68 40 13 13 6 15 20 10 1 1 1
1220 1069 1303 218 192 34 15 4 3 2 7 22 4 1 1 1
794 520 880 793 775 154 83 12 5 4 17 36 20 1 1 1
234 297 1431 1275 554 206 36 3 5 1 10 34 7 1 1 1
696 445 837 617 605 380 282 59 53 24 8 49 38 1 1 1
241 143 561 1150 794 417 695 1 1 37 1 44 8 1 1 1
1562 846 800 313 238 82 84 26 70 36 29 4 3 1 1 1
656 1507 399 527 458 271 143 15 15 15 15 15 15 15 15 15
1237 717 1030 481 431 89 39 13 1 6 29 15 4 2 1 1
602 497 1517 1336 12 12 12 12 12 12 12 12 12 12 12 12
1164 107 508 23 172 340 216 210 231 375 439 148 56 44 38 25
810 560 1047 702 736 159 24 13 7 8 8 14 5 1 1 1
66 446 987 638 1480 414 38 3 3 3 3 3 3 3 3 3
124 292 218 593 1176 23 26 196 45 51 80 104 207 316 470 175
50 51 51 52 54 54 59 62 81 81 126 249 1387 1349 256 134
2736 785 227 216 74 35 10 5 1 1 1 1 1 1 1 1
1858 1108 363 467 226 45 9 10 1 3 1 1 1 1 1 1
1712 1119 581 536 116 15 3 4 2 2 1 1 1 1 1 1
# Set 5: the frequencies of each cluster, which sum to 4096.
3068 1028
3244 852
2886 201 1 960 3 1 1 29 12 2
3405 112 48 525 1 1 1 1 1 1
1009 2839 1 112 2 9 3 40 54 27
1814 2211 1 64 1 1 1 1 1 1
3189 364 288 236 3 2 1 2 10 1
567 3434 1 21 5 10 2 18 27 11
2506 1 1331 252 1 1 1 1 1 1
509 3141 2 304 2 2 2 130 2 2
2146 48 12 1858 2 2 1 13 9 5
1609 1584 1 499 4 79 4 45 204 67
1884 132 9 1579 236 36 18 123 44 35
1415 100 1 2439 1 17 1 1 120 1
662 145 2 1625 18 595 43 52 853 101
830 26 1 3083 5 7 1 34 57 52
49 4039 1 1 1 1 1 1 1 1
2434 708 680 173 21 4 5 32 19 20
13 4075 1 1 1 1 1 1 1 1
2178 623 106 1096 20 12 4 14 33 10
521 23 5 1310 1739 9 14 443 14 18
1074 1960 30 602 9 111 40 50 135 85
176 320 17 623 144 1021 161 144 1234 256
624 952 3 1650 29 31 6 262 225 314
300 24 2 2407 559 78 24 372 152 178
80 457 6 1469 12 289 12 172 649 950
1418 56 7 2478 14 1 1 118 1 2
6 1 1 31 4012 5 14 21 1 4
57 33 5 156 3678 5 5 147 5 5
35 17 17 276 444 2404 332 76 424 71
69 26 7 359 7 3071 101 7 436 13
35 18 18 120 1840 52 1857 86 35 35
84 48 20 347 1693 188 218 1110 120 268
95 13 13 426 824 1187 437 190 780 131
88 13 13 778 767 596 274 311 659 597
59 813 12 288 24 163 36 581 245 1875
473 731 8 1270 437 8 8 1138 8 15
51 118 18 401 217 967 1886 68 218 152
22 22 22 81 100 101 3663 22 22 41
103 23 23 126 2786 191 524 158 58 104
2783 522 352 308 3 27 3 3 92 3
257 759 12 693 12 804 12 12 1523 12
1267 243 922 33 306 1077 248
720 131 252 77 341 431 2144
2424 271 15 12 803 340 231
1266 549 2 2 2265 2 10
2172 89 1 1 1831 1 1
2377 68 27 12 737 300 575
2051 13 188 21 160 1158 505
2286 58 22 18 493 848 371
1608 2 881 2 2 1594 7
2216 1 227 1 1 1638 12
3917 1 1 1 150 13 13
3001 1 16 1 14 1027 36
1943 12 471 17 259 1222 172
2680 35 1 2 1317 8 53
2514 15 14 1 629 631 292
2531 33 70 21 366 636 439
557 844 1106 187 478 97 457 33 174 24 62 12 19 38 8
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
389 1571 1502 189 279 31 44 5 44 13 9 5 5 5 5
1715 486 816 188 332 139 251 26 64 28 27 5 17 1 1
2481 234 684 105 266 31 180 23 39 6 1 19 10 16 1
1901 463 822 137 383 118 181 20 37 10 8 7 5 3 1
229 440 607 266 720 183 905 90 394 45 156 35 21 3 2
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
80 478 689 1328 770 228 177 112 81 63 69 8 11 1 1
1198 81 96 381 1235 140 375 83 267 57 118 41 22 1 1
1958 26 27 425 1150 66 181 37 118 16 42 24 24 1 1
1316 68 110 447 1048 204 361 88 220 55 109 35 33 1 1
1350 465 1335 110 462 72 2 37 6 1 50 206
672 346 1164 157 740 55 2 141 28 2 125 664
440 345 277 175 160 1690 421 104 19 5 220 240
1125 583 340 92 56 1829 3 19 1 1 21 26
1601 1054 573 315 133 1 2 92 19 1 188 117
1507 1134 551 312 156 85 10 92 16 1 104 128
1009 723 774 288 449 60 54 158 37 6 184 354
1126 807 514 327 209 85 37 417 32 6 299 237
621 360 444 124 219 1837 4 155 23 8 106 195
800 526 752 224 549 63 4 177 42 19 273 667
313 267 472 233 391 55 20 295 92 21 958 979
418 465 337 372 349 52 231 349 63 12 837 611
624 406 336 268 186 56 50 957 107 57 563 486
328 175 224 99 193 1817 11 391 46 70 241 501
414 150 129 31 26 3253 1 32 5 1 30 24
196 168 248 151 278 49 1500 110 54 1 602 739
589 369 258 174 186 9 389 894 139 20 596 473
795 687 370 257 129 134 1176 19 2 1 394 132
2298 886 593 97 71 1 1 46 2 1 41 59
1875 335 1353 49 300 67 1 10 1 1 11 93
2030 791 899 66 146 83 5 17 1 1 13 44
1768 761 528 161 120 1 2 258 51 1 260 185
1410 1403 566 387 88 1 5 51 5 1 118 61
1567 1574 388 347 46 64 7 24 3 1 54 21
1225 786 1040 268 397 72 25 49 10 2 108 114
457 332 467 185 553 77 92 302 139 27 368 1097
1404 529 364 158 83 41 12 1009 39 6 233 218
1341 686 630 154 239 52 17 502 34 7 156 278
748 404 252 64 42 2480 1 34 6 1 29 35
365 218 115 48 33 3184 1 59 9 2 26 36
2218 678 875 49 139 1 1 36 2 1 35 61
3406 326 253 12 9 1 1 32 1 1 22 32
2937 660 348 19 11 96 1 8 1 1 5 9
2586 800 501 51 34 1 1 41 2 1 37 41
2015 1336 533 71 39 55 5 13 1 1 10 17
2464 407 310 68 35 1 1 370 37 1 199 203
1993 737 539 100 118 98 8 302 21 1 52 127
3058 491 365 26 19 1 3 29 1 1 43 59
1726 1448 338 292 38 34 82 25 1 1 87 24
2101 1070 560 157 47 1 7 47 3 1 66 36
2027 1359 351 183 37 64 11 20 2 1 31 10
1295 1303 369 401 100 53 299 46 5 1 182 42
1451 518 364 197 197 1 13 439 75 11 324 506
791 696 456 382 395 67 26 222 59 46 440 516
1533 470 480 131 189 70 4 593 83 36 207 300
302 109 86 16 13 3526 1 19 1 1 11 11
160 150 106 112 62 20 2944 31 1 1 380 129
678 411 328 160 220 39 1136 318 1 1 307 497
1627 735 333 185 36 1 897 4 1 1 172 104
1004 831 230 241 32 242 1260 6 1 1 222 26
1437 854 1049 132 355 69 12 47 4 1 56 80
2395 540 838 62 75 1 6 72 1 1 65 40
2328 875 589 98 41 87 7 24 1 1 29 16
1225 2007 135 529 26 49 21 14 1 1 79 9
1040 1376 199 625 86 55 73 146 19 1 339 137
689 1413 287 850 165 57 224 28 5 2 320 56
653 820 379 659 213 77 88 179 58 11 719 240
230 415 176 493 134 52 588 327 97 26 1115 443
886 624 310 282 57 1 1543 5 1 1 315 71
541 561 161 276 51 84 1956 28 1 1 362 74
1104 634 728 224 421 40 30 286 22 5 190 412
228 487 118 593 134 49 43 298 154 79 1159 754
465 292 750 86 807 39 5 174 120 27 85 1246
780 346 430 154 382 21 9 507 119 29 377 942
640 355 590 159 581 63 10 439 80 13 228 938
1274 377 448 175 297 1 9 701 21 2 329 462
522 373 457 261 595 88 35 524 36 6 373 826
932 577 469 286 269 19 53 467 80 21 515 408
241 185 440 138 746 55 26 226 133 33 480 1393
228 143 155 106 172 1 23 384 144 136 1125 1479
47 37 82 69 201 38 40 311 107 125 1111 1928
163 111 206 116 231 1515 26 205 112 62 447 902
371 194 236 86 320 1 422 289 120 1 952 1104
68 53 105 90 137 24 1205 151 167 1 1477 618
164 130 138 74 195 53 32 1456 234 68 702 850
45 34 31 49 128 30 60 837 292 329 1004 1257
279 210 176 134 199 17 688 405 392 1 992 603
166 123 148 45 87 3150 4 103 17 5 96 152
354 187 284 130 290 1 1557 35 1 1 741 515
154 136 198 93 209 78 2101 60 1 1 626 439
2301 333 353 37 73 1 1 735 9 1 96 156
542 220 206 153 184 1 15 629 205 233 632 1076
160 134 167 109 226 46 31 547 56 376 798 1446
617 437 657 218 428 67 16 631 119 85 312 509
730 202 217 68 138 1 29 927 258 117 601 808
113 97 94 126 127 54 53 912 64 576 636 1244
769 420 341 138 97 2132 6 61 5 1 67 59
308 122 141 64 77 2795 1 135 48 15 174 216
377 132 126 51 43 2811 4 312 35 6 87 112
163 102 104 8 9 3674 1 12 1 1 9 12
218 110 127 23 23 3531 1 20 2 1 19 21
145 88 90 26 24 3430 1 129 26 1 67 69
123 67 61 8 7 3791 1 13 1 1 11 12
145 90 91 21 17 3377 266 7 1 1 45 35
81 96 62 75 19 60 3400 1 1 1 269 31
1 1 1 1 1 3 4042 1 1 1 25 18
896 495 703 357 355 198 272 132 228 135 182 69 69 3 1 1
1592 590 645 331 322 142 139 93 85 48 68 26 10 3 1 1
1803 726 733 297 233 86 88 41 36 20 18 8 4 1 1 1
2140 694 621 234 181 58 62 33 34 14 11 8 3 1 1 1
2331 722 535 184 147 57 41 23 28 8 9 5 3 1 1 1
1435 863 997 375 227 72 47 23 24 13 9 6 2 1 1 1
1255 1017 1204 353 171 42 25 6 12 2 3 2 1 1 1 1
830 601 997 672 618 209 91 23 21 6 9 9 7 1 1 1
312 391 1127 1013 942 209 65 9 15 3 5 1 1 1 1 1
763 513 737 563 727 362 244 89 45 14 9 17 6 5 1 1
122 87 369 694 1281 918 470 111 20 13 1 6 1 1 1 1
1226 715 826 416 379 173 186 71 51 22 18 9 1 1 1 1
312 319 235 234 137 804 1319 525 162 7 7 7 7 7 7 7
1427 827 623 383 381 111 106 52 72 70 20 17 3 2 1 1
404 182 137 305 83 305 358 249 680 228 398 300 245 89 77 56
457 509 44 282 90 120 128 245 464 497 635 297 112 88 76 52
1288 909 699 210 381 193 227 116 13 13 9 22 4 4 4 4
270 486 91 247 283 469 95 91 184 211 220 185 402 382 367 113
85 84 86 47 50 357 59 103 101 115 178 232 459 701 1051 388
50 51 51 52 54 54 59 62 81 81 126 249 1387 1349 256 134
2010 1228 420 275 83 54 13 5 1 1 1 1 1 1 1 1
1888 1187 450 348 117 64 15 13 6 2 1 1 1 1 1 1
2048 1128 439 269 109 63 11 16 6 1 1 1 1 1 1 1
# Set 6: the frequencies of each cluster, which sum to 4096.
1 4095
2444 1652
1592 467 1 1520 51 27 3 175 216 44
1720 330 52 1551 25 74 1 144 159 40
496 2476 5 549 1 14 35 179 128 213
1453 2241 1 392 1 3 1 2 1 1
1787 1051 92 996 7 16 37 28 30 52
584 3070 1 276 1 7 17 47 31 62
969 319 2495 307 1 1 1 1 1 1
187 531 422 239 10 1 1 2703 1 1
1105 166 6 1929 102 63 8 347 229 141
678 1201 9 774 96 211 50 305 586 186
1510 39 1 1432 415 99 59 328 161 52
483 99 3 2215 1 259 1 113 855 67
348 12 1 1444 55 1098 114 79 775 170
593 29 1 2326 124 84 47 289 280 323
145 3908 1 19 1 1 1 18 1 1
87 3960 5 25 14 1 1 1 1 1
14 4066 1 1 1 1 1 3 7 1
1192 932 21 1661 51 96 15 58 34 36
329 35 1 1397 1615 25 60 555 39 40
122 2600 1 81 79 116 256 391 126 324
55 100 1 175 132 2043 172 57 1242 119
458 809 3 1052 309 20 76 796 150 423
273 24 1 1872 772 137 116 573 96 232
132 217 1 1179 52 414 52 45 1167 837
426 96 6 1891 277 1 7 1154 159 79
3 1 1 42 3929 3 15 100 1 1
4 12 1 76 3580 1 1 419 1 1
9 1 1 116 253 3286 105 49 249 27
17 1 1 116 2 3478 69 1 408 3
15 1 1 62 1219 103 2449 155 68 23
11 29 1 236 2030 132 201 1237 76 143
32 1 1 207 581 1743 308 784 316 123
73 1 1 494 815 821 315 581 637 358
18 368 1 228 318 507 12 222 949 1473
58 61 1 267 1643 1 2 2048 5 10
10 35 1 95 248 1130 2169 119 258 31
9 1 1 39 86 146 3671 21 115 7
48 1 1 97 3133 181 276 188 18 153
175 3545 16 276 1 52 1 1 28 1
27 137 1 375 1 1150 1 16 2378 10
1333 1512 576 41 400 181 53
1146 1604 566 107 531 139 3
2167 851 57 95 681 112 133
2221 1073 1 15 772 6 8
2866 532 13 10 647 27 1
2423 845 110 178 417 113 10
2482 127 816 157 88 345 81
1651 609 461 324 123 45 883
2017 2 1073 1 19 976 8
1900 1 1418 1 3 772 1
3862 15 2 11 127 62 17
2064 6 440 1 78 1429 78
1910 61 894 135 121 784 191
1573 451 21 26 1663 165 197
2019 215 92 102 381 666 621
2025 404 288 198 683 113 385
131 1278 1854 159 419 38 110 5 6 5 1 75 13 1 1
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
333 1706 1509 294 163 31 52 1 1 1 1 1 1 1 1
2895 308 680 51 111 11 29 1 4 1 1 1 1 1 1
3294 114 544 43 68 10 9 1 7 1 1 1 1 1 1
1789 579 1244 95 269 32 69 7 2 5 1 1 1 1 1
190 663 1210 709 909 127 183 29 26 15 6 25 2 1 1
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
1206 1853 181 337 336 116 55 1 1 5 1 1 1 1 1
1566 471 1593 194 125 67 50 14 9 2 1 1 1 1 1
1288 690 1261 558 115 42 112 1 15 8 2 1 1 1 1
2059 250 1196 198 171 95 65 50 5 2 1 1 1 1 1
2135 1057 552 186 31 27 10 4 1 1 85 7
2268 652 364 415 117 56 4 68 1 1 122 28
897 117 175 6 33 1988 690 105 1 1 18 65
2406 218 91 4 5 1249 1 99 1 1 8 13
1961 1093 218 644 30 1 4 14 1 1 125 4
2323 644 160 94 3 285 4 558 4 1 19 1
1715 495 621 253 355 21 5 164 22 3 185 257
2491 197 537 24 164 176 1 343 6 1 104 52
2901 280 155 2 8 635 1 99 1 1 7 6
1664 1308 302 145 82 121 2 235 4 1 111 121
1661 347 426 44 602 5 5 272 291 5 5 433
2568 221 333 27 404 21 11 146 107 1 113 144
2177 366 279 166 166 51 1 693 22 1 72 102
1025 52 465 4 34 2403 1 79 1 1 22 9
821 148 101 11 28 2727 5 182 1 1 29 42
1921 297 1105 4 108 390 128 47 1 1 25 69
2360 176 454 38 63 72 406 398 22 1 24 82
1475 1408 138 82 28 81 833 5 1 1 29 15
2887 757 258 83 25 1 14 27 1 1 20 22
2903 660 340 43 13 92 11 4 1 1 23 5
2858 534 403 16 8 222 2 42 1 1 7 2
2476 474 412 81 65 1 2 342 13 1 180 49
1939 1262 415 307 55 1 14 11 1 1 65 25
2187 568 579 21 21 315 1 330 1 1 71 1
1738 220 1024 44 815 7 7 19 6 1 48 167
2496 55 1035 18 59 284 3 62 1 1 45 37
2320 137 127 11 12 34 3 1323 3 1 61 64
2133 247 539 52 127 29 3 738 39 1 76 112
1150 189 46 10 4 2177 4 412 1 1 25 77
1083 231 55 4 3 2511 50 95 1 1 8 54
2720 720 411 76 57 1 16 37 1 1 36 20
3758 106 87 16 14 1 14 46 1 1 23 29
3467 128 63 3 2 287 3 93 1 1 19 29
2898 500 408 93 66 1 11 39 1 1 48 30
2292 1028 280 15 9 249 7 123 1 1 87 4
3007 109 78 14 23 1 1 613 4 1 128 117
3109 137 73 1 1 169 1 565 1 1 9 29
3497 174 167 18 21 1 99 29 1 1 39 49
2898 267 513 29 57 88 139 35 1 1 55 13
2533 453 807 80 80 1 23 47 1 1 48 22
2658 186 373 5 13 266 11 339 1 1 241 2
2293 294 865 34 304 83 143 8 1 1 27 43
2681 127 158 44 66 1 14 474 7 1 291 232
2462 122 414 5 41 315 2 482 31 1 109 112
3472 64 97 11 13 32 1 358 5 1 14 28
365 44 25 2 11 3344 1 238 1 1 8 56
1731 114 193 1 8 17 2013 5 1 1 10 2
3014 157 329 22 38 5 331 118 1 1 36 44
2119 120 78 12 9 1 1703 1 1 1 22 29
1552 341 61 6 2 499 1574 3 1 1 26 30
1978 477 1030 58 387 46 15 12 1 1 36 55
2567 273 897 31 161 1 25 65 1 1 44 30
2853 152 653 21 50 140 18 117 1 1 77 13
1895 174 440 2 2 148 33 745 2 2 651 2
797 163 106 1 49 146 1 2718 1 1 72 41
1968 150 1204 15 539 67 1 1 1 1 12 137
2854 188 623 1 32 255 12 27 1 1 54 48
825 243 345 5 177 776 1700 5 5 5 5 5
1414 259 973 49 104 1 1228 4 1 1 35 27
1028 104 706 6 104 207 1812 11 1 1 60 56
1540 245 1085 50 866 1 7 27 6 1 46 222
704 167 82 337 693 65 38 166 103 63 1432 246
1832 299 633 334 89 1 1 449 127 1 200 130
3185 81 311 19 42 1 1 237 12 1 78 128
1523 689 438 165 129 83 2 717 69 1 144 136
2464 109 177 36 57 1 5 569 2 1 333 342
2789 175 359 15 36 316 2 273 1 1 47 82
2027 149 405 85 262 3 3 596 85 1 199 281
2742 23 762 1 19 296 1 126 1 1 56 68
1877 144 195 61 66 1 1 421 121 1 431 777
2035 318 18 18 18 1281 18 18 18 18 318 18
2357 27 995 5 76 616 1 1 12 1 4 1
3094 166 270 82 50 1 1 121 18 1 138 154
1196 53 53 68 57 277 264 164 114 34 1249 567
2829 126 456 1 16 111 1 389 13 1 26 127
1860 30 30 30 30 31 26 896 217 137 473 336
3312 37 381 1 12 47 1 199 1 1 28 76
1517 101 429 1 25 1983 1 17 1 1 1 19
2707 71 219 31 8 1 924 1 1 1 69 63
2141 53 1072 1 16 582 226 1 1 1 1 1
2679 86 84 7 9 1 1 1099 1 1 58 70
2016 93 62 1 1 1 1 1540 130 1 99 151
1570 3 639 3 3 1810 3 3 53 3 3 3
914 136 2271 73 89 264 1 285 27 1 25 10
2086 115 170 92 63 1 1 1392 41 1 1 133
2642 26 26 24 25 22 19 683 163 139 161 166
931 300 140 10 29 2337 5 217 1 1 34 91
958 87 383 2 25 2599 3 22 9 1 1 6
1573 237 134 1 11 1974 1 141 1 1 1 21
76 25 14 2 3 3832 3 70 1 1 16 53
98 210 172 60 30 3204 6 125 1 1 38 151
66 42 8 3 3 2631 2 1200 5 1 36 99
26 7 7 1 3 3988 2 15 1 1 8 37
140 81 11 3 2 2922 848 6 1 1 14 67
478 94 58 21 4 136 3290 1 1 1 9 3
4 3 5 2 3 7 4028 1 1 1 10 31
1161 492 786 529 664 296 158 2 1 1 1 1 1 1 1 1
1292 378 590 393 936 463 35 1 1 1 1 1 1 1 1 1
3676 157 87 22 53 90 2 1 1 1 1 1 1 1 1 1
3214 367 72 28 172 233 1 1 1 1 1 1 1 1 1 1
3502 184 153 16 77 141 14 1 1 1 1 1 1 1 1 1
1850 746 1136 227 115 12 1 1 1 1 1 1 1 1 1 1
1968 491 393 297 464 265 137 9 9 9 9 9 9 9 9 9
1026 161 259 554 1657 340 81 2 2 2 2 2 2 2 2 2
871 236 572 1035 629 213 109 64 62 50 50 44 41 40 40 40
1302 853 136 133 597 415 204 112 87 48 52 38 37 28 28 26
103 109 235 374 800 685 691 347 172 102 105 86 85 69 67 66
161 141 221 217 367 330 513 432 476 275 331 162 164 113 103 90
75 73 101 109 199 260 684 686 763 360 227 128 165 108 84 74
170 133 169 141 193 166 239 329 444 333 689 366 247 177 164 136
70 66 84 90 131 134 218 392 720 358 626 471 386 141 121 88
61 57 65 69 88 88 144 359 680 685 882 435 165 130 112 76
105 93 120 108 138 126 158 146 226 184 342 260 427 571 727 365
58 57 64 64 80 86 112 151 305 349 365 306 672 633 607 187
52 51 53 53 57 57 66 72 114 129 201 262 517 790 1185 437
50 51 51 52 54 54 59 62 81 81 126 249 1387 1349 256 134
3565 483 35 1 1 1 1 1 1 1 1 1 1 1 1 1
3293 732 58 1 1 1 1 1 1 1 1 1 1 1 1 1
824 930 198 228 156 206 171 236 188 244 248 192 116 70 49 40
# Set 7: the frequencies of each cluster, which sum to 4096.
3412 684
3396 700
1236 531 1 1988 21 1 1 99 158 60
1672 14 361 1874 5 14 1 87 63 5
938 2387 1 358 1 12 16 113 117 153
1281 2448 1 360 1 1 1 1 1 1
2456 15 859 746 1 1 1 1 1 15
608 3414 1 46 1 1 1 2 15 7
1685 1 1515 889 1 1 1 1 1 1
759 2426 15 817 1 1 1 74 1 1
1369 31 140 2188 37 6 4 123 119 79
941 857 1 1066 28 67 17 200 696 223
863 32 2 2087 121 91 62 418 240 180
1008 25 42 2582 1 42 25 1 294 76
407 26 1 2047 26 166 64 64 939 356
645 7 19 2677 30 40 21 160 264 233
45 4031 1 3 1 1 1 11 1 1
2144 11 1535 346 1 1 1 55 1 1
13 4073 1 1 1 1 1 1 3 1
1911 309 315 1373 34 11 11 29 74 29
438 6 6 2386 150 6 78 654 78 294
361 1064 23 507 68 203 259 349 451 811
1 130 1 497 314 718 240 277 1035 883
276 213 1 1097 154 77 68 967 326 917
338 46 1 1852 223 62 62 783 146 583
62 169 1 1380 66 210 78 297 927 906
1012 35 121 2287 18 1 1 533 53 35
52 47 47 569 3080 50 58 99 47 47
14 14 14 622 1077 14 470 1843 14 14
27 24 24 1080 374 1279 77 41 886 284
29 22 22 774 23 1752 47 23 1145 259
53 42 42 88 933 116 2097 145 520 60
2 154 2 245 640 215 609 1405 154 670
134 6 6 774 262 262 198 1226 902 326
145 74 3 644 181 288 181 822 787 971
10 227 1 417 201 280 150 494 885 1431
472 274 1 1056 63 1 1 2189 26 13
48 136 4 356 621 665 757 312 488 709
68 53 53 94 160 176 3224 66 131 71
48 29 29 76 2179 409 172 1033 45 76
2080 50 695 1017 4 4 4 4 234 4
3 853 3 696 3 160 3 34 2338 3
1274 1081 499 82 778 311 71
770 907 603 337 1039 419 21
1782 703 77 77 1128 127 202
2465 464 2 2 1117 2 44
3030 262 6 36 726 18 18
1665 602 162 306 975 244 142
1240 133 874 299 177 1102 271
1397 358 423 488 229 164 1037
2890 2 340 2 2 858 2
2746 8 332 11 2 978 19
3788 18 6 28 129 102 25
2218 1 176 1 102 1339 259
1511 113 663 40 150 1213 406
2007 279 65 47 1382 251 65
1389 10 116 10 433 963 1175
1330 210 250 328 646 617 715
372 609 1619 202 822 94 284 16 29 2 11 24 10 1 1
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
117 1121 1913 361 488 49 30 1 10 1 1 1 1 1 1
1359 459 1341 172 565 65 109 9 11 1 1 1 1 1 1
2036 225 1313 134 280 44 38 6 14 1 1 1 1 1 1
1152 578 1453 199 487 79 126 10 6 1 1 1 1 1 1
219 611 1234 560 1000 140 242 25 29 11 8 12 3 1 1
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
1192 1159 162 684 693 57 57 48 1 38 1 1 1 1 1
750 580 2058 244 189 120 105 18 18 5 5 1 1 1 1
108 684 1678 1338 78 73 119 5 2 5 1 2 1 1 1
1442 250 1607 317 201 123 95 24 18 13 2 1 1 1 1
2453 517 869 16 64 112 27 11 5 1 16 5
1760 813 1037 184 94 139 4 4 4 4 49 4
946 222 264 27 57 1010 1462 34 3 1 28 42
2434 248 235 35 32 955 53 42 1 1 21 39
2018 972 309 593 2 2 25 2 2 2 167 2
2124 912 295 265 25 233 36 83 1 1 85 36
1643 217 825 41 595 271 244 109 14 1 68 68
1548 218 755 53 542 245 90 404 1 1 69 170
1793 390 322 42 95 769 90 348 21 5 105 116
1869 1067 424 153 18 86 18 153 18 1 136 153
522 184 157 603 154 55 37 900 108 65 910 401
1875 342 594 55 127 181 324 288 19 1 199 91
1872 370 290 97 33 113 129 996 33 1 65 97
1631 139 413 47 139 710 25 528 2 2 253 207
1127 195 274 41 42 2075 124 130 3 1 53 31
1894 75 813 11 113 199 796 65 5 1 54 70
1590 389 262 13 32 181 1428 50 1 1 81 68
1298 1250 176 100 5 179 1055 5 1 1 14 12
3064 514 312 56 42 1 14 42 1 1 35 14
3046 217 543 2 41 199 8 12 1 1 6 20
2826 433 428 45 52 201 37 33 1 1 15 24
2221 542 207 341 6 6 73 274 6 6 341 73
1905 1004 308 308 208 9 109 109 9 9 9 109
2337 615 475 149 58 205 68 75 3 1 78 32
1596 277 1103 52 639 213 39 39 1 1 13 123
2285 173 752 8 47 219 94 353 8 8 47 102
1967 216 101 24 13 123 18 1279 2 1 99 253
1800 363 382 10 29 105 77 926 20 20 220 144
1581 257 226 28 35 1736 60 105 1 1 27 39
1462 220 112 18 13 1864 273 73 9 1 18 33
2944 388 483 69 35 1 43 18 1 1 18 95
3789 135 74 6 10 1 27 28 1 1 12 12
3504 181 118 9 12 166 38 29 1 1 18 19
2653 760 418 53 67 1 84 13 1 1 27 18
2427 788 446 37 55 169 85 26 1 1 33 28
3366 171 114 1 20 1 20 228 1 1 96 77
2844 189 118 13 7 183 40 538 3 1 99 61
3452 244 134 4 13 1 211 10 1 1 10 15
2881 339 115 11 9 90 616 12 1 1 16 5
2659 508 434 79 58 1 222 69 1 1 53 11
2672 444 366 70 33 224 164 43 1 1 61 17
2145 417 266 41 20 91 1073 9 1 1 20 12
2517 186 490 18 52 1 18 473 1 1 102 237
2442 205 395 9 93 140 50 395 4 1 119 243
3279 146 141 1 17 107 6 242 39 6 56 56
1082 137 121 14 30 2523 38 95 1 1 17 37
874 171 179 4 12 47 2744 31 1 1 18 14
1720 270 800 9 99 135 782 171 1 1 45 63
1551 341 102 18 3 1 2055 1 1 1 15 7
1369 306 88 18 6 123 2151 1 1 1 24 8
2064 354 920 63 330 126 95 55 1 1 16 71
2928 202 495 35 63 1 244 91 1 1 28 7
2822 165 546 17 73 190 138 65 1 1 43 35
1730 1216 349 160 70 80 319 20 1 1 120 30
2066 301 640 101 181 321 101 121 1 1 181 81
1213 415 859 161 98 34 1144 34 3 3 66 66
1975 289 776 90 245 134 46 179 2 2 179 179
1323 156 659 27 65 388 1215 91 1 1 143 27
1027 195 477 20 27 1 2278 1 1 1 61 7
912 166 552 16 32 103 2262 2 1 1 34 15
1001 328 866 40 1391 136 78 97 1 1 21 136
125 210 103 899 111 81 48 209 129 80 1792 309
1734 78 651 78 365 221 6 365 78 6 221 293
2993 15 328 15 15 15 15 171 15 15 484 15
1634 386 648 71 194 176 19 456 36 1 211 264
2094 243 403 82 56 2 29 697 2 2 350 136
1948 212 363 34 43 221 40 670 3 3 295 264
2004 307 408 3 70 3 37 645 70 37 408 104
2382 80 940 54 28 184 28 132 28 2 54 184
575 83 82 97 87 46 51 280 169 134 1467 1025
427 28 227 235 30 25 21 870 54 50 1132 997
2113 11 360 11 11 1059 11 244 127 11 11 127
886 81 80 97 93 37 67 616 115 37 1132 855
894 26 546 33 27 21 1522 79 55 16 602 275
1783 251 546 251 152 4 4 497 251 4 201 152
1764 194 21 21 21 195 18 353 152 96 852 409
2497 17 547 17 193 17 547 193 17 17 17 17
1018 120 204 61 37 1970 96 288 49 13 120 120
2454 161 480 2 55 2 905 2 2 2 2 29
2135 149 451 20 35 119 1145 10 1 1 25 5
2601 177 313 21 21 1 21 859 1 1 40 40
226 144 136 124 112 52 56 802 297 225 1001 921
2542 18 18 18 18 405 212 212 18 599 18 18
1155 341 1813 178 178 15 15 15 178 15 178 15
123 77 75 67 543 46 48 1891 284 201 380 361
1763 304 14 304 14 14 14 741 14 14 741 159
1489 393 362 43 62 1507 47 69 1 1 51 71
1625 134 438 19 39 1400 19 58 29 1 162 172
1975 234 225 10 10 1297 39 186 1 1 30 88
378 132 181 6 21 3280 35 24 1 1 9 28
343 432 478 43 102 2532 62 26 1 1 23 53
219 162 67 10 48 3214 29 153 1 1 39 153
151 58 47 4 7 3753 42 12 1 1 4 16
423 191 68 18 3 1924 1433 2 1 1 17 15
333 178 45 45 3 99 3359 1 1 1 25 6
2 7 2 4 3 4 4048 1 1 1 11 12
1331 734 999 506 316 183 15 4 1 1 1 1 1 1 1 1
1805 662 985 408 159 40 28 1 1 1 1 1 1 1 1 1
3478 276 189 79 32 32 1 1 1 1 1 1 1 1 1 1
2824 755 359 122 3 3 3 3 3 3 3 3 3 3 3 3
2568 976 448 8 8 8 8 8 8 8 8 8 8 8 8 8
1088 676 1793 357 114 58 1 1 1 1 1 1 1 1 1 1
1097 1597 809 150 82 44 44 36 35 31 31 29 28 27 28 28
2178 1018 300 157 300 13 13 13 13 13 13 13 13 13 13 13
665 293 711 698 791 265 135 80 78 62 62 55 51 50 50 50
1295 154 271 264 448 350 405 222 174 96 104 75 73 57 55 53
103 109 235 374 800 685 691 347 172 102 105 86 85 69 67 66
161 141 221 217 367 330 513 432 476 275 331 162 164 113 103 90
75 73 101 109 199 260 684 686 763 360 227 128 165 108 84 74
170 133 169 141 193 166 239 329 444 333 689 366 247 177 164 136
70 66 84 90 131 134 218 392 720 358 626 471 386 141 121 88
61 57 65 69 88 88 144 359 680 685 882 435 165 130 112 76
105 93 120 108 138 126 158 146 226 184 342 260 427 571 727 365
58 57 64 64 80 86 112 151 305 349 365 306 672 633 607 187
52 51 53 53 57 57 66 72 114 129 201 262 517 790 1185 437
50 51 51 52 54 54 59 62 81 81 126 249 1387 1349 256 134
3463 581 28 12 1 1 1 1 1 1 1 1 1 1 1 1
3792 234 5 5 5 5 5 5 5 5 5 5 5 5 5 5
2653 175 107 123 84 112 93 128 102 132 135 104 63 38 26 21
# Set 8: the frequencies of each cluster, which sum to 4096.
1218 2878
638 3458
2766 90 1 1225 1 1 5 2 2 3
2563 1 48 1477 1 1 1 1 2 1
1570 2432 1 80 1 1 1 3 3 4
1838 2159 1 92 1 1 1 1 1 1
2980 142 542 424 2 1 1 1 1 2
1055 2986 1 48 1 1 1 1 1 1
1707 8 2214 161 1 1 1 1 1 1
1368 2207 17 338 1 1 1 161 1 1
1956 1 8 2121 1 1 1 3 2 2
2127 539 6 1126 19 37 12 52 140 38
1670 40 16 1625 315 67 34 181 94 54
1933 6 7 2102 1 17 1 5 22 2
504 33 14 1878 34 717 101 49 663 103
1451 1 1 2620 2 4 1 4 6 6
510 3578 1 1 1 1 1 1 1 1
1680 754 1581 71 2 1 1 4 1 1
284 3804 1 1 1 1 1 1 1 1
1733 1197 205 852 34 19 8 16 20 12
429 41 21 1458 1529 32 48 414 51 73
2491 505 68 896 5 15 17 30 25 44
63 110 23 310 159 1519 164 105 1381 262
704 877 8 1834 66 19 22 251 95 220
666 69 14 2248 397 73 52 318 106 153
80 181 21 1162 53 260 52 201 742 1344
2013 5 7 2022 8 1 1 35 3 1
33 26 26 128 3685 29 39 77 26 27
42 34 23 190 3129 23 80 529 23 23
35 25 25 320 312 2639 183 62 413 82
48 26 24 256 25 2965 84 24 589 55
45 28 28 99 1322 113 2129 155 127 50
56 60 23 276 1620 194 243 1260 106 258
72 23 23 339 531 1337 318 509 793 151
99 32 22 549 625 690 275 465 755 584
37 279 22 257 261 340 75 466 567 1792
233 167 20 944 938 20 20 1703 25 26
42 65 23 178 288 984 1867 126 334 189
47 30 30 82 159 149 3419 39 88 53
64 27 27 115 2907 195 317 288 58 98
1943 1223 741 134 3 12 3 3 31 3
91 281 22 549 22 965 22 32 2087 25
2393 91 285 136 336 373 482
2426 73 283 131 317 367 499
2465 148 85 88 487 353 470
2605 429 5 6 1013 8 30
3003 235 5 2 841 2 8
2461 158 96 75 467 369 470
2393 30 271 98 358 491 455
2119 255 127 140 403 568 484
2665 5 530 26 6 858 6
3164 1 271 1 7 645 7
3949 8 7 14 51 41 26
3066 13 83 1 8 917 8
2279 36 280 116 374 577 434
3069 57 1 1 955 6 7
2229 80 43 71 514 532 627
2245 46 113 68 546 539 539
1163 731 1413 123 242 32 157 14 97 12 19 22 41 20 10
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
250 1092 1460 420 567 81 79 14 18 14 12 53 12 12 12
1611 334 691 135 183 178 422 86 270 15 15 14 120 11 11
2569 291 550 63 183 34 219 22 31 18 17 33 25 24 17
1752 449 956 67 385 63 238 13 53 11 11 11 69 9 9
2703 544 730 35 38 16 10 5 4 2 2 2 3 1 1
274 273 273 273 273 273 273 273 273 273 273 273 273 273 273
903 211 205 593 692 468 580 149 176 44 51 12 10 1 1
702 107 123 381 534 436 569 261 363 179 221 131 85 2 2
33 235 489 813 993 399 694 54 225 38 99 14 8 1 1
1636 140 179 424 549 222 423 102 190 59 79 63 28 1 1
1586 656 1202 65 384 42 74 11 3 1 24 48
815 197 1490 55 1188 31 13 25 4 1 41 236
1079 466 484 123 99 1113 587 27 5 1 54 58
2520 486 270 16 11 775 5 2 1 1 3 6
1659 1069 634 289 222 1 52 41 7 1 59 62
1604 933 805 209 217 77 49 71 7 1 75 48
1309 748 883 246 283 57 149 145 14 1 152 109
1658 445 1342 73 226 69 18 169 8 1 44 43
1346 621 359 90 44 1474 55 50 8 1 30 18
1288 666 947 153 587 46 25 44 13 2 82 243
514 290 748 193 908 40 25 93 51 9 337 888
1039 674 715 355 261 33 83 165 48 3 330 390
1087 609 556 213 236 94 7 560 93 3 404 234
1115 466 595 130 169 472 1 302 57 40 451 298
1245 242 355 30 24 2172 4 7 1 1 8 7
1153 420 530 107 315 52 537 162 1 1 236 582
1386 612 367 133 100 157 1032 122 10 1 107 69
1395 1011 367 142 85 106 933 1 1 1 27 27
2398 1412 180 58 9 1 17 4 1 1 11 4
2190 1354 392 33 46 49 10 3 1 1 10 7
2388 1234 285 40 29 89 13 4 1 1 8 4
1662 770 575 198 164 1 85 347 14 2 178 100
2305 1030 262 386 12 1 16 12 3 1 58 10
2817 610 436 134 12 45 8 5 1 1 24 3
1403 1119 684 503 143 58 22 13 2 1 113 35
1274 471 542 161 498 62 102 59 125 5 345 452
1702 561 434 58 52 127 20 959 29 1 96 57
1701 615 606 102 138 55 11 487 48 2 204 127
1431 344 299 11 11 1974 5 9 1 1 3 7
1281 400 236 36 20 1997 84 19 1 1 8 13
2552 1188 281 17 29 1 11 4 1 1 5 6
3047 651 375 7 3 1 4 2 1 1 2 2
2917 663 386 8 3 106 4 2 1 1 3 2
2686 885 473 21 9 1 6 5 1 1 6 2
2626 845 514 24 9 59 6 4 1 1 5 2
2186 519 380 112 59 1 37 603 15 2 127 55
2080 591 527 74 40 101 38 439 5 1 141 59
2884 759 397 8 7 1 29 1 1 1 5 3
2489 562 738 19 10 75 181 3 1 1 10 7
2975 510 546 28 11 1 10 3 1 1 7 3
2777 474 727 27 12 60 5 3 1 1 6 3
2423 592 708 60 32 71 180 5 1 1 16 7
1800 691 589 126 249 1 17 130 17 3 308 165
1716 661 796 189 252 68 25 79 18 2 146 144
1735 457 411 103 103 116 15 619 168 3 248 118
1221 281 383 8 7 2178 3 6 1 1 3 4
621 209 338 42 71 9 2718 1 1 1 43 42
1520 725 570 90 171 70 587 147 1 1 102 112
1876 625 565 37 34 1 921 1 1 1 17 17
1752 613 583 35 35 170 873 1 1 1 20 12
1747 498 1365 25 313 66 12 9 1 1 9 50
2805 390 854 6 20 1 9 3 1 1 3 3
2757 387 835 6 21 76 4 3 1 1 3 2
2031 412 1530 40 19 35 7 4 1 1 11 5
1776 726 1100 235 76 39 16 32 2 1 74 19
2015 837 627 374 59 47 23 8 3 1 89 13
1205 791 911 479 185 66 21 47 13 1 260 117
993 484 744 579 155 82 445 55 17 2 431 109
1447 447 1030 48 91 1 981 1 1 1 26 22
1412 396 1059 46 113 98 908 1 1 1 30 31
1645 385 1453 61 325 42 18 27 3 1 37 99
553 569 477 599 156 38 5 101 70 19 1215 294
607 214 1270 79 1056 24 34 92 27 7 77 609
924 240 606 85 742 17 39 139 126 19 350 809
1039 417 961 131 454 57 66 248 31 5 187 500
1072 492 760 146 218 1 82 491 6 1 374 453
1081 459 678 168 278 72 44 337 13 1 301 664
999 618 575 472 257 31 39 343 47 3 422 290
446 286 512 451 583 27 5 58 23 9 771 925
217 63 117 158 339 3 5 380 163 39 1348 1264
112 75 114 175 268 37 3 165 92 28 1599 1428
755 124 302 238 228 707 20 70 132 15 814 691
499 210 225 281 186 4 64 262 74 4 1150 1137
472 277 316 161 133 92 506 116 56 4 1098 865
443 307 372 260 293 58 1 802 77 27 653 803
264 59 86 70 152 76 20 920 402 85 1066 896
742 190 414 136 291 9 170 349 106 2 729 958
943 328 412 95 149 1301 25 105 41 4 351 342
1487 404 483 86 117 1 861 3 1 1 351 301
1117 441 461 102 299 51 654 1 1 1 384 584
2191 533 416 84 41 1 1 496 7 1 98 227
587 114 71 52 157 4 6 868 245 98 746 1148
328 115 117 73 237 66 9 361 76 37 1356 1321
939 445 609 298 752 20 20 381 47 13 249 323
468 86 91 49 104 5 9 1529 274 125 607 749
197 106 11 175 184 13 21 1456 176 79 1189 489
1546 399 443 50 36 1565 10 20 2 1 11 13
566 415 373 245 171 1230 22 146 146 13 356 413
840 458 283 122 116 1244 25 533 123 11 161 180
357 194 366 7 7 3152 4 2 1 1 1 4
315 257 351 20 12 3121 4 6 1 1 3 5
212 231 200 75 40 2648 19 510 16 1 65 79
261 144 191 6 4 3482 1 1 1 1 1 3
372 210 368 31 29 2362 671 1 1 1 20 30
194 101 124 36 41 20 3519 1 1 1 36 22
1 4 3 4 2 3 3980 1 1 1 18 78
627 225 197 115 176 122 98 52 114 74 17 186 341 1 3 1748
1755 255 222 132 278 170 130 55 285 132 24 179 475 1 1 2
2476 491 332 191 170 53 46 23 93 31 26 62 99 1 1 1
3061 388 245 88 72 50 6 18 34 21 14 29 67 1 1 1
3228 435 172 98 69 18 11 5 25 4 9 8 11 1 1 1
1915 1043 862 133 53 12 26 4 17 13 3 6 6 1 1 1
1671 1174 1031 162 18 5 5 6 8 7 1 4 1 1 1 1
1208 680 1146 569 407 29 22 9 7 11 2 2 1 1 1 1
398 277 1253 1147 871 64 25 12 12 7 8 7 5 4 3 3
1327 859 797 325 358 280 60 29 17 14 9 6 6 3 3 3
334 173 368 350 728 839 836 162 84 45 46 39 36 22 18 16
222 151 831 1264 933 374 189 27 34 25 18 8 8 5 4 3
132 217 282 457 437 413 655 458 448 194 139 65 87 49 34 29
820 408 447 306 206 173 219 188 264 205 366 182 114 75 67 56
175 129 283 286 155 175 263 310 592 355 578 335 242 90 74 54
238 105 116 86 117 132 181 331 602 731 806 326 127 84 70 44
1294 367 418 182 190 115 136 96 123 87 149 104 239 207 262 127
94 165 193 171 340 244 203 145 284 298 345 235 456 422 387 114
63 84 84 128 217 101 101 112 156 191 322 284 501 599 848 305
34 33 32 37 74 34 49 51 62 175 126 239 1536 1293 216 105
2212 1431 253 120 37 29 4 2 1 1 1 1 1 1 1 1
2802 791 219 112 60 29 11 15 10 13 12 9 6 4 2 1
1867 904 249 203 100 113 81 113 84 110 110 81 43 21 11 6
`;function to(n){let e=n.length/17,t=new Uint8Array(e*64);for(let r=0;r<e;r+=1){let o=0;for(let s=0;s<64;s+=1){for(;s<<6>=n[r*17+o+1];)o+=1;t[r*64+s]=o}}return{starts:n,buckets:t}}var ro=8,u2={families:[["frame",2,2,2],["mode",363,10,40],["smallMode",32,7,16],["change",12,15,12],["pixel",810,12,96],["escape",36,16,20],["candidate",3,16,3]],sets:9,text:eo},l2={families:[["node",40,4,8],["planes",324,16,12],["coded",96,2,8],["last",384,11,12],["lastBits",22,4,3],["levels",1296,16,32],["paletteSize",4,16,4],["paletteColor",1,16,1],["row",2,2,2],["pixel",16,3,16],["laterFrame",2,2,2],["laterRow",2,2,2],["laterPixel",16,4,16]],sets:10,text:Zn},no={};function d2(){return no.depth??=so(u2)}function rt(){return no.color??=so(l2)}function oo(n){return n==="depth"?d2():rt()}function so(n){let e=n.text.replaceAll(/#.*/g,"").trim().split(/\s+/).map(Number),t=0,r=()=>{let l=e[t];if(l===void 0||!Number.isInteger(l))throw new Error("a file of entropy tables breaks its format");return t+=1,l},o=f2(n.families),s=o.flatMap(l=>Array.from({length:l.contexts},()=>l.firstDistribution+r())),i=o.flatMap(l=>Array(l.distributions).fill(l.alphabet)),a=Array.from({length:n.sets},()=>io(i,()=>r(),!0));if(t!==e.length)throw new Error("a file of entropy tables has more numbers than its format says");let c=n.families.map(([l],d)=>[l,o[d].firstContext]);return{firstContext:Object.fromEntries(c),distributionOf:Uint8Array.from(s),alphabets:Uint8Array.from(i),builtIn:a}}function f2(n){let e=0,t=0;return n.map(([,r,o,s])=>{let i={firstContext:e,contexts:r,alphabet:o,firstDistribution:t,distributions:s};return e+=r,t+=s,i})}function io(n,e,t){let r=new Uint16Array(n.length*17).fill(4096);for(let o=0;o<n.length;o+=1){let s=o*17;r[s]=0;let i=0;for(let a=1;a<n[o];a+=1){if(i+=e(),i>4096)throw new _(`The frequencies of distribution ${o} sum to more than ${4096} (entropy.md 4).`);r[s+a]=i}if(t&&i+e()!==4096)throw new Error(`the frequencies of distribution ${o} do not sum to ${4096}`)}return to(r)}function nt(n,e,t){if(e>ro){let o=n==="depth"?"depth.md 3":"color.md 2";throw new _(`A codec header has ${e} table sets, at most ${ro} are legal (${o}).`)}let{alphabets:r}=oo(n);return{model:n,own:Array.from({length:e},()=>io(r,t,!1))}}function ao(n){return{model:n,own:[]}}function co(n){return[...oo(n.model).builtIn,...n.own]}var H=class{bytes;#e;#t;at=0;constructor(e,t){this.bytes=e,this.#e=new DataView(e.buffer,e.byteOffset,e.byteLength),this.#t=t}get remaining(){return this.bytes.length-this.at}error(e){return new _(`${e}, at offset ${this.at} (${this.#t}).`)}skip(e){let t=this.at;if(!(e<=this.remaining))throw this.error(`${e} more bytes were expected where ${this.remaining} are left`);return this.at+=e,t}u8(){return this.bytes[this.skip(1)]}u16(){return this.#e.getUint16(this.skip(2),!0)}u32(){return this.#e.getUint32(this.skip(4),!0)}f32(){return this.#e.getFloat32(this.skip(4),!0)}f64(){return this.#e.getFloat64(this.skip(8),!0)}zeros(e){let t=this.skip(e);if(this.bytes.subarray(t,t+e).some(r=>r!==0))throw this.error("A reserved byte is not 0")}varint(){let e=0;for(let t=0;t<5;t+=1){let r=this.u8();if(e+=(r&127)*2**(7*t),r===0&&t>0)throw this.error("A number is not in its shortest form");if(r<128)return e}throw this.error("A number has more than five bytes")}finish(){if(this.remaining>0)throw this.error(`${this.remaining} bytes are left behind the last field`)}};var uo="color.md 2",lo=3,O1=4,h2=new Map([["CCL8",{isHalf:!1}],["CCB1",{isHalf:!1,blocks:"bc1"}],["CCB7",{isHalf:!1,blocks:"bc7"}],["CCLH",{isHalf:!0}],["CCB6",{isHalf:!0,blocks:"bc6h"}],["CTR8",{isHalf:!1,isTransform:!0}],["CTRH",{isHalf:!0,isTransform:!0}]]);function fo(n,e,t){let r=h2.get(n);if(r===void 0)throw new g(`The codec ${JSON.stringify(n)} of a color stream is not known (${uo}).`);let o=new H(e,uo),s=o.f64();if(!Number.isFinite(s))throw o.error("The PSNR is no finite number");let i=r.isHalf?p2(o):m2(o),a={name:"cells",blocks:r.blocks};if(r.isTransform){let c=o.f64();if(!(c>=0&&c<=100))throw o.error("The quality is not within 0 to 100");let u=o.u8();if(u!==lo)throw o.error(`A stream has ${u} planes of color, ${lo} were expected`);o.zeros(3),a={name:"transform",tables:nt("color",o.u8(),()=>o.varint())}}if(r.blocks!==void 0&&(t.unitWidth%O1!==0||t.unitHeight%O1!==0))throw o.error(`The sides of units are no multiples of ${O1} pixels`);return o.finish(),{kind:"color",isHalf:r.isHalf,...i,minPsnrDb:s,coding:a}}function m2(n){let e=n.f32();if(!(e>=-32&&e<=32))throw n.error(`An exposure of ${e} stops is not within -32 to 32`);let t=n.u32();if(t>1)throw n.error(`The transfer function ${t} is not known`);return{transfer:t===0?"srgb":"linear",exposureEv:e}}function p2(n){let e=n.f64();if(!(Number.isFinite(e)&&e>0))throw n.error(`A white of ${e} candelas per square meter is not finite and above 0`);return{transfer:"linear",exposureEv:0}}var ho=Uint32Array.of(0,94364,188362,281996,375270,468185,560745,652952,744810,836320,927485,1018309,1108793,1198939,1288752,1378232,1467383,1556207,1644705,1732882,1820738,1908277,1995500,2082410,2169009,2255299,2341283,2426963,2512340,2597417,2682196,2766679,2850868,2934766,3018374,3101694,3184728,3267478,3349946,3432134,3514044,3595678,3677038,3758124,3838941,3919488,3999768,4079782,4159533,4239023,4318251,4397222,4475935,4554394,4632599,4710552,4788255,4865709,4942916,5019878,5096595,5173071,5249305,5325300,5401057,5476578,5551864,5626916,5701737,5776327,5850688,5924821,5998727,6072409,6145867,6219103,6292118,6364913,6437490,6509850,6581994,6653924,6725641,6797146,6868440,6939525,7010402,7081072,7151536,7221795,7291852,7361706,7431359,7500812,7570066,7639123,7707984,7776649,7845119,7913397,7981483,8049377,8117082,8184598,8251926,8319067,8386022,8452793,8519380,8585785,8652008,8718050,8783912,8849596,8915102,8980431,9045584,9110562,9175366,9239998,9304457,9368745,9432863,9496811,9560591,9624203,9687648,9750928,9814042,9876993,9939780,10002404,10064867,10127170,10189312,10251295,10313120,10374787,10436298,10497652,10558852,10619897,10680789,10741528,10802114,10862550,10922835,10982970,11042956,11102794,11162484,11222028,11281425,11340677,11399784,11458748,11517568,11576245,11634780,11693175,11751428,11809542,11867517,11925353,11983051,12040612,12098037,12155325,12212479,12269497,12326382,12383133,12439752,12496238,12552593,12608817,12664911,12720875,12776710,12832416,12887994,12943445,12998770,13053968,13109041,13163988,13218811,13273511,13328087,13382540,13436871,13491080,13545168,13599135,13652983,13706711,13760320,13813810,13867183,13920438,13973576,14026597,14079503,14132294,14184969,14237530,14289978,14342312,14394532,14446641,14498638,14550523,14602297,14653961,14705514,14756958,14808293,14859519,14910637,14961648,15012551,15063347,15114037,15164621,15215099,15265473,15315742,15365906,15415967,15465925,15515779,15565531,15615181,15664730,15714177,15763523,15812769,15861915,15910962,15959909,16008758,16057508,16106160,16154714,16203172,16251532,16299796,16347964,16396036,16444013,16491896,16539683,16587377,16634976,16682482,16729896,16777216);var wo="depth.md 3",P1=1024,mo=255,po=256,bo=4096,y2=512,_2=131071;function go(n,e,t){if(!["DAAB","DAB5","DQPN","DQTR","DB4W","DPRD"].includes(n))throw N1("depth",n);let r=new H(e,wo),[o,s,i,a]=[r.f32(),r.f32(),r.f32(),r.u32()];if(!(o>0&&o<=s&&Number.isFinite(s)))throw r.error(`Depths from ${o} m to ${s} m are no range`);if(Number.isNaN(i))throw r.error("The background value is not a number");if(a>1)throw r.error(`Depth has measure ${a}, which is unknown`);let c=v2(n,r,t);return r.finish(),{kind:"depth",range:{nearM:o,farM:s},background:i,isDistance:a===0,coding:c}}function v2(n,e,t){if(n==="DAAB"||n==="DAB5"){let r=n==="DAB5";return xo(r,e,t),{name:"boxes",inBlocks:r,...Eo(e)}}switch(vo(e,t),n){case"DB4W":return{name:"blocks"};case"DPRD":{let r=k2(e);if(r.projection.shape===2&&t.width!==t.height)throw e.error(`A cube face has ${t.width}x${t.height} pixels, which is no square`);return r}default:return x2(e,n==="DQTR")}}function yo(n,e,t){if(n!=="MAAB"&&n!=="MAB1")throw N1("material",n);let r=new H(e,wo),o=n==="MAB1";xo(o,r,t);let{window:s}=Eo(r);return r.finish(),{kind:"material",window:s,inBlocks:o}}function _o(n,e,t){if(n!=="APRD")throw N1("alpha",n);let r=new H(e,"depth.md 16");vo(r,t);let o=st(r);return r.finish(),{kind:"alpha",coding:{name:"predictive",keyframeInterval:o,bound:0,epsilon:0,projection:{shape:0,octave:0},levels:new Uint16Array,tables:ao("depth")}}}function N1(n,e){let t=Array.from(e,r=>/[ -~]/u.test(r)?r:"?").join("");return new g(`A stream of ${n} has codec '${t}', which this player does not know.`)}function vo(n,{unitWidth:e,unitHeight:t}){if(e>P1||t>P1)throw n.error(`Tiles have ${e}x${t} pixels, at most ${P1} a side are legal`)}function xo(n,e,{unitWidth:t,unitHeight:r}){if(n&&(t%4!==0||r%4!==0))throw e.error(`Tiles have ${t}x${r} pixels, where multiples of 4 were expected`)}function st(n){let e=n.u32();if(e===0)throw n.error("A keyframe interval has 0 frames");return e}function ko(n,e){if(e<1||e>mo)throw n.error(`A window has ${e} frames where 1 to ${mo} are legal`)}function Eo(n){let e=n.u16();ko(n,e);let t=n.u16();if(t<1||t>po)throw n.error(`Records have at most ${t} boxes where 1 to ${po} are legal`);return n.skip(2),n.zeros(2),{window:e,keyframeInterval:st(n)}}function x2(n,e){let t=n.u16();if(ko(n,t),e&&t!==1)throw n.error(`A window has ${t} frames, which an intermediate form cannot have`);n.skip(2);let r=st(n);n.skip(2);let o={kind:n.u16(),base:n.u32(),scale:n.u32()};if(o.kind>2)throw n.error(`Domain ${o.kind} is unknown`);if(!(o.kind===0?o.base===0&&o.scale===0:o.base<402653184&&o.scale>0))throw n.error(`Domain ${o.kind} has base ${o.base} and scale ${o.scale}, which is illegal`);return{name:"nodes",window:t,isTree:e,domain:o,keyframeInterval:r}}function k2(n){let e=n.u16();if(e>65534)throw n.error(`A bound has ${e} codes, at most ${65534} are legal`);let t=n.u16(),r=st(n),[o,s,i,a]=[n.u16(),n.u8(),n.u8(),n.u32()],c=E2(n,o,a),u=nt("depth",i,()=>n.varint());if(s>1)throw n.error(`Levels are of kind ${s}, which is unknown`);if(s===1&&(e!==0||t!==0||o!==0))throw n.error("A stream with a bound, a threshold or a projection has levels");let l=s===1?S2(n):new Uint16Array;return{name:"predictive",keyframeInterval:r,bound:e,epsilon:t,projection:c,levels:l,tables:u}}function E2(n,e,t){if(e!==0&&e!==1&&e!==2)throw n.error(`Projection ${e} is unknown`);if(e===0?t!==0:t<y2||t>_2)throw n.error(`Projection ${e} has ${t} codes for a factor of two, which is illegal`);return{shape:e,octave:t}}function S2(n){let e=n.u16();if(e<1||e>bo)throw n.error(`A stream has ${e} levels where 1 to ${bo} are legal`);let t=new Uint16Array(e),r=-1;for(let o=0;o<e;o+=1){if(t[o]=n.u16(),t[o]<=r||t[o]>65534)throw n.error(`Level ${t[o]} behind ${r} is illegal: levels ascend, up to ${65534}`);r=t[o]}return t}var R2={color:["CTR8","CTRH","CCL8","CCB1","CCB7","CCLH","CCB6"],depth:["DQPN","DQTR","DAAB","DPRD","DB4W","DAB5"],material:["MAAB","MAB1"],alpha:["APRD"]},A2=["DAB5","MAB1","CCB1","CCB7","CCB6"],F1=4;function So(n,e){let{kind:t,codec:r,unitWidth:o,unitHeight:s}=n;if(!R2[t].includes(r))throw new g(`A stream of ${t} has codec ${M2(r)}, which this player does not know.`);if(A2.includes(r)&&(o%F1!==0||s%F1!==0))throw new _(`A stream of codec ${r} has units of ${o}x${s} pixels, whose sides are no multiples of ${F1}.`);switch(t){case"depth":return go(r,e,n);case"material":return yo(r,e,n);case"alpha":return _o(r,e,n);case"color":return fo(r,e,n)}}function M2(n){return`"${n.replace(/[^A-Za-z0-9]/gu,e=>`\\x${e.charCodeAt(0).toString(16).padStart(2,"0")}`)}"`}var T2=/[\u0000-\u001f\u007f-\u009f]/u,G=class extends H{section;#e;#t;constructor(e,t,r){super(e,t),this.section=t,this.#e=r,this.#t=new DataView(e.buffer,e.byteOffset,e.byteLength)}error(e,t=this.at){return new _(`${e}, at byte ${this.#e+t} (${this.section}).`)}take(e){let t=this.skip(e);return this.bytes.subarray(t,t+e)}u64(e){let t=this.skip(8),r=this.#t.getUint32(t,!0)+this.#t.getUint32(t+4,!0)*2**32;if(!Number.isSafeInteger(r))throw this.error(`${e} is larger than any file`,t);return r}finites(e,t){return Array.from({length:e},()=>{let r=this.at,o=this.f64();if(!Number.isFinite(o))throw this.error(`${t} is ${o}, where a finite number was expected`,r);return o})}varint32(){let e=this.at,t=this.varint();if(t>=2**32)throw this.error(`${t} is more than 32 bits hold`,e);return t}string(e){let t=this.take(this.u16());try{return new TextDecoder("utf-8",{fatal:!0,ignoreBOM:!0}).decode(t)}catch{throw this.error(`${e} is not UTF-8`,this.at-t.length)}}fits(e,t,r){if(e*r>this.remaining)throw this.error(`${e} ${t} do not fit into the rest of the index`)}};function Ro(n){return T2.test(n)}function le(n){let t=Array.from(n.slice(0,80)).slice(0,40);return`"${t.map(o=>/^[ -~]$/u.test(o)?o:`\\u{${(o.codePointAt(0)??0).toString(16)}}`).join("")}${t.join("").length<n.length?"...":""}"`}var Q=16,Ao=16384,Ne=2**31,C2=2**30,Mo=2**22,O2={raw:1,lzma2:16384,zstd:32768},it=["raw","lzma2","zstd"],U1=/^[A-Za-z0-9_-][A-Za-z0-9._-]*$/u;function To(n){return Math.ceil(n.width/n.unitWidth)}function N(n){return To(n)*Math.ceil(n.height/n.unitHeight)}function S(n,e){let t=To(n),r=e%t*n.unitWidth,o=Math.floor(e/t)*n.unitHeight;return[r,o,Math.min(n.unitWidth,n.width-r),Math.min(n.unitHeight,n.height-o)]}function at(n){let e=n.u8();if(n.zeros(3),e>1)throw n.error(`Projection ${e} is unknown`);let[t]=n.finites(1,"The frame rate");if(t<=0)throw n.error(`A frame rate of ${t} is not positive`);let r=n.at,o=n.string("The dataset's name");if(Ro(o))throw n.error("The dataset's name holds control characters",r);return{projection:e,fps:t,name:o}}function de(n,e){return n.finites(3,e)}function fe(n,e){return n.finites(4,e)}function ct(n,e,{name:t,frames:[r,o]}){if(!U1.test(t))throw n.error(`The probe name ${le(t)} has other than letters, digits, ".", "_" and "-"`,e);if(r>o||o>=Ne)throw n.error(`A probe is active from frame ${r} to ${o}`,e)}function ut(n,e,t,r){let{kind:o,face:s,probe:i,width:a,height:c,unitWidth:u,unitHeight:l,firstFrame:d,frameCount:f}=t;if(o>3||s>6)throw n.error(`A stream has kind ${o} and face ${s}, which is unknown`,e);if(i>=r)throw n.error(`A stream is of probe ${i}, where the file has ${r}`,e);if([a,c,u,l].some(h=>h<1||h>Ao)){let h=`${a}x${c} pixels in units of ${u}x${l}`;throw n.error(`A stream has ${h}, where each size is 1 to ${Ao}`,e)}if(f<1||d+f>Ne)throw n.error(`A stream has ${f} frames from frame ${d} on, which is impossible`,e)}function lt(n,e,t,r){let{offset:o,storedBytes:s,rawBytes:i,storage:a}=t;if(o<Q||o+s>r)throw n.error(`A chunk of ${s} bytes at byte ${o} lies outside the file's chunks`,e);let c=Math.min(C2,s*O2[a]);if(i>c||a==="raw"&&i!==s)throw n.error(`A chunk of ${s} stored bytes cannot mean ${i} bytes`,e)}function dt(n,e,t){if(n.fits(e,"chunks",t),e>Mo)throw new g(`The container has ${e} chunks; this player reads at most ${Mo}.`)}function ft(n,e){let t=new Set;for(let{name:o}of n){if(t.has(o))throw new _(`Two probes are named ${le(o)} (container.md 4).`);t.add(o)}let r=new Set;e.forEach(({kind:o,probe:s,face:i},a)=>{let c=(s*4+o)*7+i;if(r.has(c))throw new _(`Stream ${a} has the kind, probe and face of an earlier one (container.md 5).`);r.add(c)})}function L1(n,e){let t=new Uint32Array(n.length+1),r=0;if(n.forEach((o,s)=>{if(r+=N(o),r>e)throw new _(`The chunk table breaks off: the streams have more units than its ${e} rows (container.md 6).`);t[s+1]=r}),r===0&&e>0)throw new _(`The index has ${e} chunks and no stream (container.md 6).`);return t}function ht(n,e){let t=L1(n,e.length),r=new Uint32Array(t[n.length]+1),o=0,s=(i,a,c)=>new _(`The chunk table breaks off at stream ${i}, unit ${a}, frame ${c}: chunks must cover the frames of each unit in order (container.md 6).`);if(n.forEach(({firstFrame:i,frameCount:a},c)=>{let u=i+a;for(let l=0;l<t[c+1]-t[c];l+=1){for(let d=i;d<u;o+=1){let f=e.at(o),h=f?.stream===c&&f.unit===l&&f.firstFrame===d;if(!f||!h||f.frameCount<1||d+f.frameCount>u)throw s(c,l,d);d+=f.frameCount}r[t[c]+l+1]=o}}),o<e.length){let{stream:i,unit:a,firstFrame:c}=e[o];throw s(i,a,c)}return{firstUnits:t,firstChunks:r}}var P2=4,N2=/^[a-z0-9_.]{1,64}$/u,F2=2**32-1,U2=[.64,.33,.3,.6,.15,.06,.3127,.329],L2=1e-9,Fe=["color","depth","material","alpha"];function Oo(n){n.section="container.md 6.4";let e=n.varint32();if(e===0)throw n.error("An attribute table has no attributes");n.fits(e,"attributes",P2);let t=new Map,r="";for(let o=0;o<e;o+=1){let s=n.at,i=n.string("An attribute's name");if(!N2.test(i))throw n.error(`${le(i)} is no name of an attribute`,s);if(i<=r)throw n.error(`The attribute ${i} does not ascend by name`,s);r=i,t.set(i,n.take(n.varint32()))}return t}function Po(n){let e={chromaticities:U2,clippedPixels:void 0,missingFrames:[],poses:new Map},t=a=>{let c=n.get(a);return c&&new G(c,`container.md 6.6, ${a}`,0)},r=t("color.chromaticities");r&&(e.chromaticities=I2(r));let o=t("color.clipped_pixels");o&&(e.clippedPixels=o.u32()+o.u32()*2**32,o.finish());let s=t("frames.missing");for(;s&&s.remaining>0;)e.missingFrames.push(B2(s,e.missingFrames.at(-1)));let i=t("probes.poses");return i&&(e.poses=D2(i)),e}function I2(n){let e=Array.from({length:8},()=>n.f32());n.finish();let[t,r,o,s]=[0,2,4,6].map(l=>{let[d,f]=[e[l],e[l+1]];return[d/f,1,(1-d-f)/f]}),i=[t,r,o,s].flat().every(l=>Number.isFinite(l)),a=mt(t,r,o),u=[mt(s,r,o),mt(t,s,o),mt(t,r,s)].every(l=>Number.isFinite(l/a)&&l!==0);if(!i||!(Math.abs(a)>=L2)||!u)throw new _(`The chromaticities ${e.join(", ")} span no colors (${n.section}).`);return e}function mt(n,e,t){return n[0]*(e[1]*t[2]-e[2]*t[1])+n[1]*(e[2]*t[0]-e[0]*t[2])+n[2]*(e[0]*t[1]-e[1]*t[0])}function No(n){let e=n.at,t=n.string("A probe's name");if(!U1.test(t))throw n.error(`${le(t)} is no name of a probe`,e);return t}function I1(n,e,t){if(t>=Ne)throw n.error(`A row names frame ${t}, frames are numbered below ${Ne}`,e)}function B2(n,e){let t=n.at,r=No(n),[o,s,i,a]=[n.u8(),n.u8(),n.u32(),n.u32()];if(o>=Fe.length||s>6)throw n.error(`A missing frame is of kind ${o} and face ${s}, which is unknown`,t);let c={probe:r,kind:Fe[o],face:s,frame:i,held:a===F2?void 0:a};if(I1(n,t,i),I1(n,t,c.held??0),e&&!Fo(Co(e),Co(c)))throw n.error("Rows of missing frames do not ascend",t);return c}function Co({probe:n,kind:e,face:t,frame:r}){return[n,Fe.indexOf(e),t,r]}function Fo(n,e){let t=n.findIndex((r,o)=>r!==e[o]);return t>=0&&n[t]<e[t]}function D2(n){let e=new Map,t;for(;n.remaining>0;){let r=n.at,o=No(n),s=n.u32();I1(n,r,s);let i=de(n,"A position"),a=fe(n,"An orientation");if(t&&!Fo(t,[o,s]))throw n.error("Rows of poses do not ascend by probe and frame",r);t=[o,s];let c=e.get(o);c?c.push({frame:s,position:i,orientation:a}):e.set(o,[{frame:s,position:i,orientation:a}])}return e}var Ue=H2();function H2(){let n=new Uint32Array(1024);for(let e=0;e<256;e+=1){let t=e;for(let r=0;r<8;r+=1)t=t>>>1^(t&1?3988292384:0);n[e]=t}for(let e=256;e<1024;e+=1){let t=n[e-256];n[e]=t>>>8^n[t&255]}return n}function pt(n){let e=4294967295,t=n.length-n.length%4,r=0;for(;r<t;r+=4){let o=e^(n[r]|n[r+1]<<8|n[r+2]<<16|n[r+3]<<24);e=Ue[768+(o&255)]^Ue[512+(o>>>8&255)]^Ue[256+(o>>>16&255)]^Ue[o>>>24]}for(;r<n.length;r+=1)e=e>>>8^Ue[(e^n[r])&255];return~e>>>0}var q=40,Le=[1,2],B1=[137,76,70,76,68,13,10,26],G2=[76,70,78,68],z2="container.md 7";function Uo(n){let e=new G(n,"container.md 3",0),t=e.take(Math.min(B1.length,n.length));if(t.length<B1.length||B1.some((s,i)=>t[i]!==s))throw new _("This is not a lightfold container: its first 8 bytes are other (container.md 3).");let[r,o]=[e.u16(),e.u16()];if(r!==Le[0])throw new g(`The container has format version ${r}; this player reads version ${Le[0]}.`);return e.zeros(4),o}function D1(n,e){let t=e-q;if(!Io(n))throw new _("The container has no foot: it was cut short, so copy or encode it again (container.md 7).");let r=new G(n,z2,t);if(pt(n.subarray(0,32))!==new DataView(n.buffer,n.byteOffset).getUint32(32,!0))throw r.error("The foot's CRC-32 does not match: the file is damaged");let[o,s]=[r.u64("The index's offset"),r.u64("The index")],[i,a]=[r.u32(),r.u8()];r.zeros(3);let c=r.u64("The file's size");if(a>2)throw r.error(`The index has form ${a}, which is unknown`,20);if(c!==e)throw r.error(`The foot speaks of a file of ${c} bytes, this one has ${e}`,24);if(o<Q||o+s!==t)throw r.error("The index does not lie between the chunks and the foot",0);return{indexOffset:o,indexBytes:s,indexCrc32:i,form:a}}function Lo(n,e){let t=e-n.length;for(let r=n.length-1;r>=q;r-=1){let o=n.subarray(r-q,r);if(Io(o)&&$2(o,t+r))return t+r}}function Io(n){return n.length===q&&G2.every((e,t)=>n[q-4+t]===e)}function $2(n,e){try{return D1(n,e),!0}catch{return!1}}var V2=27,W2=2,j2=1,q2=2**16,K2=1,X2=2,Y2=4,Q2=1,J2=2,Z2=4,ec=8,tc=16,rc=32,nc=64,oc=128,Bo=3,sc=4,ic={name:"",position:[0,0,0],orientation:[0,0,0,1],frames:[0,0],intrinsics:[0,0,0,0]},ac={kind:0,face:-1,probe:0,codec:"\0\0\0\0",width:0,height:0,firstFrame:0,frameCount:0,unitWidth:0,unitHeight:0,headerBytes:new Uint8Array(0),chunkFrames:0};function Do(n,e,t){let r=new G(n,"container.md 6.3",e),[o,s,i]=[r.varint32(),r.varint32(),r.varint32()],a=r.u8();if(a>1)throw r.error(`Order ${a} of the chunk table is unknown`);let c=at(r);r.fits(o,"probes",V2);let u=[];for(let h=0;h<o;h+=1)u.push(cc(r,u.at(-1)??ic));r.fits(s,"streams",W2);let l=[];for(let h=0;h<s;h+=1)l.push(uc(r,l,o));dt(r,i,j2);let d=new H1(r,l,i).read(a===1,e),f=t?Oo(r):new Map;return r.finish(),ft(u,l),{...c,probes:u,streams:l,chunks:d,units:ht(l,d),attributes:f}}function cc(n,e){let t=n.at,r=n.u8();if(r>7)throw n.error(`A probe has flags ${r}, of which some are unknown`,t);let o=n.string("A probe's name"),s={...e,name:o,position:de(n,"A probe's position")};return r&K2&&(s.orientation=fe(n,"A probe's orientation")),r&X2&&(s.frames=[n.varint32(),n.varint32()]),r&Y2&&(s.intrinsics=n.finites(4,"A probe's intrinsics")),ct(n,t,s),s}function uc(n,e,t){let r=n.at,o=n.u8(),s={...e.at(-1)??ac};if(s.face+=1,o&Q2&&(s.kind=n.u8(),s.codec=String.fromCharCode(...n.take(4))),o&J2&&(s.probe=n.varint32()),o&Z2&&(s.face=n.u8()),o&ec&&([s.width,s.height]=[n.varint32(),n.varint32()]),o&tc&&([s.firstFrame,s.frameCount]=[n.varint32(),n.varint32()]),o&rc&&([s.unitWidth,s.unitHeight]=[n.varint32(),n.varint32()]),o&nc){let i=n.varint32();if(i>e.length)throw n.error(`A codec header is that of ${i} rows before, where there are ${e.length}`,r);s.headerBytes=i>0?e[e.length-i].headerBytes:n.take(n.varint32())}return o&oc&&(s.chunkFrames=n.varint32()),ut(n,r,s,Math.min(t,q2)),s}var H1=class{constructor(e,t,r){this.fields=e;this.streams=t;this.count=r;this.firstUnits=L1(t,r);let o=this.firstUnits[t.length];[this.streamOf,this.nextFrame]=[new Uint32Array(o),new Uint32Array(o)],t.forEach(({firstFrame:s},i)=>{let[a,c]=[this.firstUnits[i],this.firstUnits[i+1]];this.streamOf.fill(i,a,c),this.nextFrame.fill(s,a,c)})}fields;streams;count;firstUnits;streamOf;nextFrame;rows=[];read(e,t){let{fields:r,rows:o}=this,s=this.nextFrame.length,i=0,a=Q;for(let c=0;c<this.count;c+=1){let u=r.at,l=r.varint(),d=l%8,f=0;if(d&sc&&(f=r.varint32(),f<1||f>=s))throw r.error(`A step of ${f} units, where there are ${s}`,u);let h=(i+f)%s,m=this.frames(h,u),p=(d&3)===Bo;this.place(m,[d&3,Math.floor(l/8)],[u,a]),lt(r,u,m,t),a+=p?0:m.storedBytes,o.push(m);let{firstFrame:w,frameCount:y}=this.streams[m.stream],v=this.nextFrame[h]===w+y;i=e&&!v?h:(h+1)%s}if(a!==t)throw r.error(`The chunks end at byte ${a}, and the index starts at ${t}`);return this.sorted()}frames(e,t){let r=this.streamOf[e],o=this.streams[r],s=this.nextFrame[e],i=o.firstFrame+o.frameCount-s,a=o.chunkFrames===0?this.fields.varint32():Math.min(o.chunkFrames,i);if(a<1||a>i)throw this.fields.error(`A chunk has ${a} frames of a unit of which ${i} are left`,t);return this.nextFrame[e]+=a,{...{stream:r,unit:e-this.firstUnits[r],firstFrame:s,frameCount:a},offset:0,storedBytes:0,rawBytes:0,crc32:0,storage:"raw"}}place(e,[t,r],[o,s]){let{fields:i,rows:a}=this;if(t===Bo){let c=a.at(-1-r);if(!c)throw i.error(`A chunk has the bytes of ${r+1} rows before, where there are ${a.length}`,o);let{offset:u,storedBytes:l,rawBytes:d,crc32:f,storage:h}=c;Object.assign(e,{offset:u,storedBytes:l,rawBytes:d,crc32:f,storage:h});return}e.offset=s,e.storage=it[t],e.storedBytes=r,e.rawBytes=t===0?r:i.varint32(),e.crc32=i.u32()}sorted(){let e=new Uint32Array(this.nextFrame.length+1),t=o=>this.firstUnits[o.stream]+o.unit;this.rows.forEach(o=>e[t(o)+1]+=1);for(let o=1;o<e.length;o+=1)e[o]+=e[o-1];let r=Array(this.rows.length);for(let o of this.rows){let s=t(o);r[e[s]]=o,e[s]+=1}return r}};var lc=98,dc=36,fc=40;function Ho(n,e){let t=new G(n,"container.md 4",e),[r,o,s]=[t.u32(),t.u32(),t.u32()],i=at(t);t.fits(r,"probes",lc);let a=Array.from({length:r},()=>hc(t));t.section="container.md 5",t.fits(o,"streams",dc);let c=Array.from({length:o},()=>mc(t,r));t.section="container.md 6",dt(t,s,fc);let u=Array.from({length:s},()=>pc(t,e));t.finish(),ft(a,c);let l=ht(c,u);return{...i,probes:a,streams:c,chunks:u,units:l,attributes:new Map}}function hc(n){let e=n.at,t=n.string("A probe's name"),r=de(n,"A probe's position"),o=fe(n,"A probe's orientation"),s=[n.u32(),n.u32()],i=n.finites(4,"A probe's intrinsics"),a={name:t,position:r,orientation:o,frames:s,intrinsics:i};return ct(n,e,a),a}function mc(n,e){let t=n.at,[r,o,s]=[n.u8(),n.u8(),n.u16()],i=String.fromCharCode(...n.take(4)),[a,c,u,l]=[n.u32(),n.u32(),n.u32(),n.u32()],[d,f]=[n.u32(),n.u32()],h=n.take(n.u32()),m={kind:r,face:o,probe:s,codec:i,width:a,height:c,firstFrame:u,frameCount:l,unitWidth:d,unitHeight:f,headerBytes:h};return ut(n,t,m,e),m}function pc(n,e){let t=n.at,[r,o,s,i]=[n.u32(),n.u32(),n.u32(),n.u32()],a=n.u64("A chunk's offset"),[c,u,l,d]=[n.u32(),n.u32(),n.u32(),n.u8()];if(n.zeros(3),d>1)throw n.error(`A chunk is stored by method ${d}, which is unknown`,t);let f=it[d],h={stream:r,unit:o,firstFrame:s,frameCount:i,offset:a,storedBytes:c,rawBytes:u,crc32:l,storage:f};return lt(n,t,h,e),h}var bc=2**30,wc=1024,gc=4,yc=2**26,_c=1024,vc=2**38,xc=2**20,G1=2**26,z1=2**24,kc=4096,bt=32,Ec=4,Sc=4*2**20;function Go(n,e,t){let r=Math.max(bc,wc*t),[o,s,i]=[0,0,0];if(n.streams.forEach((a,c)=>{let u=Rc(n,c,e[c]);if(u>r)throw new g(`Stream ${c} of ${a.width}x${a.height} pixels would take ${u} bytes to decode, more than a file of ${t} bytes justifies (container.md 2).`);o+=u,s+=N(a)*a.frameCount,i+=a.width*a.height*a.frameCount}),o>gc*r)throw new g(`The streams would take ${o} bytes to decode, more than a file of ${t} bytes justifies (container.md 2).`);if(s>yc+_c*t||i>vc+xc*t)throw new g(`The streams have ${s} units and ${i} pixels in all their frames, more than a file of ${t} bytes justifies (container.md 2).`)}function Rc({streams:n,chunks:e,units:t},r,o){let s=n[r],i=s.width*s.height*Ac(o)+N(s)*kc;for(let a=t.firstUnits[r];a<t.firstUnits[r+1];a+=1){let c=0;for(let u=t.firstChunks[a];u<t.firstChunks[a+1];u+=1)c=Math.max(c,Mc(s,e[u],o));i+=c}return i}function Ac(n){switch(n.kind){case"depth":return n.coding.name==="predictive"?32:4;case"material":return 6;case"alpha":return 32;case"color":return n.isHalf?30:12}}function Mc(n,{unit:e,frameCount:t,rawBytes:r},o){if(o.kind==="depth"&&o.coding.name==="nodes")return 64*r;if(o.kind!=="color")return 10*r;let s=4*r+Math.min(8*r,Sc);if(o.coding.name==="cells")return s;let[,,i,a]=S(n,e),[c,u]=Tc(i,a),l=u*t,d=Math.min(832*r+5632*c,72*l);return Math.max(s,d+r+640*c+l)}function Tc(n,e){let t=s=>[[Math.floor(s/bt),bt],[s%bt>0?1:0,s%bt]],[r,o]=[0,0];for(let[s,i]of t(n))for(let[a,c]of t(e)){let u=Ec;for(;u<Math.max(i,c);)u*=2;r+=s*a,o+=s*a*u*u}return[r,o]}var Cc=65536,gt=class n{constructor(e,t,r,o){this.source=e;this.minorVersion=t;this.indexBytes=r;this.name=o.name,this.fps=o.fps,this.projection=o.projection===0?"cube":"perspective",this.probes=o.probes,this.chunks=o.chunks,this.units=o.units,this.attributes=o.attributes;let s=Fc(o.streams);Go(o,s,e.byteCount),this.streams=o.streams.map((i,a)=>Lc(i,a,s[a])),this.footage=Po(o.attributes)}source;minorVersion;indexBytes;name;fps;projection;probes;streams;chunks;attributes;footage;units;static async open(e,t){let r=Uo(await e.read(0,Math.min(Q,e.byteCount),t));if(e.byteCount<Q+q)throw new _(`The container ends after its head, at byte ${e.byteCount} (container.md 7).`);let o=await Oc(e,t);if(o.indexBytes>G1)throw new g(`The container has an index of ${o.indexBytes} bytes; this player reads at most ${G1}.`);let s=await e.read(o.indexOffset,o.indexBytes,t);if(pt(s)!==o.indexCrc32)throw new _(`The index's CRC-32 does not match: the file is damaged at byte ${o.indexOffset} (container.md 4).`);try{return new n(e,r,o.indexBytes,Pc(s,o))}catch(i){throw r>Le[1]?Nc(i,r):i}}probeAt(e,t){let r=this.probes[e],o=this.footage.poses.get(r.name)??[],s=o[wt(0,o.length,i=>o[i].frame>=t)];return s?.frame===t?{...r,position:s.position,orientation:s.orientation}:r}unitCount(e){return N(this.streams[e])}unitRect(e,t){return S(this.streams[e],t)}chunksOf(e,t){let r=this.units.firstUnits[e]+t;return[this.units.firstChunks[r],this.units.firstChunks[r+1]]}chunkIndex(e,t,r){let[o,s]=this.chunksOf(e,t),i=wt(o,s,c=>this.chunks[c].firstFrame>r)-1;return i>=o&&r<this.chunks[i].firstFrame+this.chunks[i].frameCount?i:-1}chunksAmong(e,t,[r,o]){let[s,i]=this.chunksOf(e,t),a=wt(s,i,c=>this.chunks[c].firstFrame+this.chunks[c].frameCount>r);return[a,wt(a,i,c=>this.chunks[c].firstFrame>o)]}placeOf(e){let{stream:t,unit:r}=this.chunks[e];return e+1===this.chunksOf(t,r)[1]?"last":"inner"}areaOf(e){let{stream:t,unit:r,frameCount:o}=this.chunks[e],{width:s,height:i,face:a}=this.streams[t];return{area:{imageSize:[s,i],face:a,rect:this.unitRect(t,r)},frames:o,place:this.placeOf(e)}}};function wt(n,e,t){let[r,o]=[n,e];for(;r<o;){let s=Math.floor((r+o)/2);t(s)?o=s:r=s+1}return r}async function Oc(n,e){let{byteCount:t}=n,r=await n.read(t-q,q,e);try{return D1(r,t)}catch(o){let s=Math.min(t,Cc),i=Lo(await n.read(t-s,s,e),t);throw i===void 0?o:new _(`The container ends at byte ${i}, and ${t-i} bytes follow it (container.md 7).`)}}function Pc(n,{form:e,indexOffset:t}){return e===0?Ho(n,t):Do(n,t,e===2)}function Nc(n,e){let t=`The format version ${Le[0]}.${e} is later than this player knows`;return n instanceof g||n instanceof _?new g(`${t}: ${n.message}`):n}function Fc(n){let e=new Map,t=0;return n.map((r,o)=>{let{kind:s,codec:i,face:a,width:c,height:u,unitWidth:l,unitHeight:d,headerBytes:f}=r,h={kind:Fe[s],codec:i,face:a,width:c,height:u,unitWidth:l,unitHeight:d},m=Object.values(h).join(),p=e.get(f)??new Map;e.set(f,p);let w=p.get(m);if(w)return w;if(t+=f.length,t>z1)throw new g(`The streams have more than ${z1} bytes of different codec headers.`);let y=Uc(h,o,f);return p.set(m,y),y})}function Uc(n,e,t){try{return So(n,t)}catch(r){throw(r instanceof _||r instanceof g)&&(r.message=`Stream ${e}: ${r.message}`),r}}function Lc(n,e,t){let{face:r,probe:o,codec:s,width:i,height:a,firstFrame:c,frameCount:u,unitWidth:l,unitHeight:d,headerBytes:f}=n;return{...{index:e,kind:t.kind,face:r,probe:o,codec:s,width:i,height:a,firstFrame:c,frameCount:u},unitWidth:l,unitHeight:d,header:t,headerBytes:f}}function yt([n,e]){let t=[],[r,o]=[n,e];for(;r>1||o>1||t.length===0;)[r,o]=[Math.ceil(r/2),Math.ceil(o/2)],t.push([r,o]);return t}function _t([n,e,t,r],o){let s=(l,d)=>{let f=l>>o+1;return[f,(l+d-1>>o+1)-f+1]},[[i,a],[c,u]]=[s(n,t),s(e,r)];return[i,c,a,u]}function zo([n,e],t,r){let[o,s]=[Math.floor(r.side/n),Math.floor(r.side/e)],i=Math.ceil(t/r.layers),a=Math.max(Math.min(i,o),1),c=Math.ceil(i/a);if(o===0||c>s){let u=o*s*r.layers;throw new g(`${t} images of ${n}x${e} texels are needed at once, and the graphics device holds ${u} of this size.`)}return{columns:a,rows:c,layers:Math.ceil(t/(a*c))}}function $o({columns:n,rows:e},t){let r=t%(n*e);return{column:r%n,row:Math.floor(r/n),layer:Math.floor(t/(n*e))}}function Vo({views:n}){let e=n.flatMap(({faces:t})=>t.map(({size:r})=>r));return[Math.max(...e.map(([t])=>t)),Math.max(...e.map(([,t])=>t))]}function Wo([n,e]){return 2**Math.ceil(Math.log2(Math.max(n,e)))}function jo(n){let[e,t]=Vo(n),r=n.views.some(({faces:s})=>s.some(({material:i})=>i!==void 0)),o=4+(n.coding.name==="light"?8:4)+(r?4:0);return e*t*o+4*Math.ceil(e/2)*Wo([e,t])}var vt=class{constructor(e,t,r){this.gpu=e;let{maxTextureDimension2D:o,maxTextureArrayLayers:s}=e.device.limits,i=Vo(t);this.pyramidRows=Wo(i);let a=[Math.ceil(i[0]/2),this.pyramidRows],c=[Math.max(i[0],a[0]),Math.max(i[1],a[1])];this.#t=zo(c,r,{side:o,layers:s}),this.#e=i,this.colorFormat=t.coding.name==="light"?"rgba16float":"rgba8unorm";let u=t.views.some(({faces:d})=>d.some(({material:f})=>f!==void 0));this.#r={inverse_depths:this.#s("inverse_depths",i,"r32uint"),pyramids:this.#s("pyramids",a,"r32uint"),colors:this.colorTexture("colors"),materials:this.#s("materials",u?i:[1,1],"rgba8unorm")};let l=d=>this.#r[d].createView({dimension:"2d-array"});this.#n={inverse_depths:l("inverse_depths"),pyramids:l("pyramids"),colors:l("colors"),materials:l("materials")},this.#o=Array.from({length:r},(d,f)=>r-1-f)}gpu;pyramidRows;colorFormat;#e;#t;#r;#n;#o;take(){return this.#o.pop()}free(e){this.#o.push(e)}view(e){return e in this.#n?this.#n[e]:void 0}origin(e){let{column:t,row:r,layer:o}=$o(this.#t,e),[s,i]=this.#e;return{texels:[t*s,r*i],pyramid:[t*Math.ceil(s/2),r*this.pyramidRows],layer:o}}colorTexture(e){return this.#s(e,this.#e,this.colorFormat)}upload(e,t,[r,o,s,i],a){let{texels:[c,u],layer:l}=this.origin(t),d=typeof e=="string"?this.#r[e]:e;this.gpu.queue.writeTexture({texture:d,origin:[c+r,u+o,l]},a,{bytesPerRow:s*4*a.BYTES_PER_ELEMENT},[s,i,1])}copyColor(e,t,r,o){let{texels:s,layer:i}=this.origin(t);this.#i(e,o,{texture:this.#r.colors,at:[...s,i]},r)}copyDepth(e,t,r,{planes:o,face:s}){let{texels:i,pyramid:a,layer:c}=this.origin(t);o.levels(s).forEach((u,l)=>{let d=l===0?r:_t(r,l-1),f={buffer:o.planes,at:u.at+d[1]*u.pitch+d[0],pitch:u.pitch};if(l===0)this.#i(e,f,{texture:this.#r.inverse_depths,at:[...i,c]},d);else{let h=this.pyramidRows-this.pyramidRows/2**(l-1);this.#i(e,f,{texture:this.#r.pyramids,at:[a[0],a[1]+h,c]},d)}})}#s(e,[t,r],o){let{columns:s,rows:i,layers:a}=this.#t;return this.gpu.device.createTexture({label:e,size:[t*s,r*i,a],format:o,usage:GPUTextureUsage.TEXTURE_BINDING|GPUTextureUsage.COPY_DST})}#i(e,{buffer:t,at:r,pitch:o},{texture:s,at:[i,a,c]},[u,l,d,f]){let h=f>1?{offset:4*r,bytesPerRow:4*o}:{offset:4*r};e.copyBufferToTexture({buffer:t,...h},{texture:s,origin:[i+u,a+l,c]},[d,f,1])}};function K(n,e){return[n[0]+e[0],n[1]+e[1],n[2]+e[2]]}function z(n,e){return[n[0]-e[0],n[1]-e[1],n[2]-e[2]]}function k(n,e){return[n[0]*e,n[1]*e,n[2]*e]}function X(n,e){return n[0]*e[0]+n[1]*e[1]+n[2]*e[2]}function Ie(n,e){return[n[1]*e[2]-n[2]*e[1],n[2]*e[0]-n[0]*e[2],n[0]*e[1]-n[1]*e[0]]}function T(n){return Math.sqrt(X(n,n))}function xt(n,e){return T(z(n,e))}function he(n){return k(n,1/T(n))}function me([n,e,t,r]){let o=Math.sqrt(n*n+e*e+t*t+r*r),s=1/o;return Math.abs(o-1)<=.001?[n*s,e*s,t*s,r*s]:void 0}function pe([n,e,t,r],o){let s=[n,e,t],i=k(s,2*X(o,s)),a=k(Ie(s,o),2*r);return K(K(k(o,r*r-X(s,s)),i),a)}function qo([n,e,t,r]){return[-n,-e,-t,r]}function Ko({eye:n,yaw:e,pitch:t},r,o){let s=[-Math.sin(e)*Math.cos(t),Math.sin(t),-Math.cos(e)*Math.cos(t)],i=[Math.cos(e),0,-Math.sin(e)],a=Math.tan(r*Math.PI/360);return{eye:n,axes:[s,i,Ie(s,i)],half:[a*o,a]}}function Xo(n,e){let t=r=>({...n,eye:K(n.eye,k(n.axes[1],r))});return[t(-e/2),t(e/2)]}function Yo(n,e){let t=({eye:o,axes:s,half:i})=>[...o,...s.flat(),...i],r=t(e);return t(n).every((o,s)=>o===r[s])}var $1=1e100,Qo=1e-7,Ic=1e-13,Jo=1e-14;function Be(n,e,t,r){let[o,s,i]=e,[[a,c],[u,l]]=[t.u,t.v],d=(w,y)=>K(K(o,k(s,w)),k(i,y)),f=[d(a,u),d(c,u),d(c,l),d(a,l)],h=f.map(he),m=[he(z(i,k(o,u))),he(z(k(o,c),s)),he(z(k(o,l),i)),he(z(s,k(o,a)))],p=f.reduce((w,y)=>Math.max(w,T(y)),0);return{apex:n,axes:e,window:t,nearM:r,corners:f,rays:h,sides:m,reach:p}}function Zo({apex:n,axes:e,rays:t,sides:r,reach:o,nearM:s}){let i=c=>Math.abs(T(c)-1)<1e-6;return n.every(c=>Number.isFinite(c))&&o<$1&&[...e,...t,...r].every(i)&&s>=0&&s<$1}function Bc({sides:n},e){return n.every(t=>X(t,e)>=0)}function Dc({apex:n,axes:e,window:t,nearM:r,reach:o},s){let i=2*s*o*o;if(!(i<=.2*o))return;let a=([c,u])=>[c-i,u+i];return Be(n,e,{u:a(t.u),v:a(t.v)},r)}function ts(n,e){let t=Ie(n,e),r=1/T(t);return Number.isFinite(r)&&r>0?k(t,r):void 0}function Hc(n,e){let t=(s,i)=>i.every(a=>X(s,a)>=-Jo),r=(s,i)=>i.every(a=>X(s,a)<=Jo);if(n.sides.some(s=>r(s,e.rays))||e.sides.some(s=>r(s,n.rays)))return!0;let o=(s,i)=>{let a=ts(s,i);return a!==void 0&&(t(a,n.rays)&&r(a,e.rays)||r(a,n.rays)&&t(a,e.rays))};return n.rays.some(s=>e.rays.some(i=>o(s,i)))}function es({corners:n,nearM:e},t,r){let o=Math.min(e,r),[s,i]=[1/0,-1/0];for(let a of n){let c=X(a,t);s=Math.min(s,c),i=Math.max(i,c)}return[s*(s<0?r:o),i*(i<0?o:r)]}function Gc(n,e,t){let r=z(e.apex,n.apex),o=t*n.reach+t*e.reach+T(r)+T(n.apex)+T(e.apex);if(!(o<=$1))return!1;let s=Ic*o,i=l=>{let[d,f]=es(n,l,t),[h,m]=es(e,l,t),p=X(r,l);return h+p-f>s||d-m-p>s},a=({axes:l,sides:d})=>[l[0],...d],c=({axes:l,rays:d})=>[l[1],l[2],...d];if(a(n).some(i)||a(e).some(i))return!0;let u=c(e);return c(n).some(l=>u.some(d=>{let f=ts(l,d);return f!==void 0&&i(f)}))}var kt=class{#e;#t;constructor(e){this.#e=e,this.#t=Zo(e)?Dc(e,Qo):void 0}sight(e){return this.#t===void 0||!Zo(e)?"partly":e.rays.every(t=>Bc(this.#e,t))?"inside":!Hc(this.#t,e)||!this.#r(e)?"partly":"missed"}#r(e){let t=xt(this.#e.apex,e.apex);return t===0||Gc(this.#e,e,2*t/Qo)}};var ns=6,[De,zc,V1]=[[1,0,0],[0,1,0],[0,0,1]],[rs,be,Et]=[[-1,0,0],[0,-1,0],[0,0,-1]],$c=[[De,Et,be],[rs,V1,be],[zc,De,V1],[be,De,Et],[V1,De,be],[Et,rs,be],[Et,De,be]];function os(n,[e,t],r){let[o,s,i,a]=r;return n===ns?{scale:[o,s],center:[i,a]}:{scale:[e/2,t/2],center:[e/2,t/2]}}function St({scale:n,center:e},t,r){let{fround:o}=Math,s=(c,u)=>o(o(c+.5-o(e[u]))/o(n[u])),[i,a]=[s(t,0),s(r,1)];return o(Math.sqrt(o(o(1+o(i*i))+o(a*a))))}function ss(n,e,[t,r]){let o=me(n.orientation),s=$c[e];if(o===void 0||s===void 0)return;let[i,a,c,u]=n.intrinsics,l=e===ns?(h,m)=>[(h-c)/i,(m-u)/a]:(h,m)=>[2*h/t-1,2*m/r-1],d=[...l(0,0),...l(1,1)].every(h=>Number.isFinite(h)),f=s.map(h=>pe(o,h));return d?{center:n.position,axes:f,plane:l}:void 0}function is({center:n,axes:e,plane:t},r,o,{margin:s,nearM:i}){let a=t(r[0]-s,r[1]-s),c=t(o[0]+s,o[1]+s),u=m=>[Math.min(a[m],c[m]),Math.max(a[m],c[m])],[l,d]=[u(0),u(1)],f=([m,p])=>Math.max(Math.abs(m),Math.abs(p)),h=Math.sqrt(1+f(l)**2+f(d)**2);return Be(n,e,{u:l,v:d},i/h)}function we({depth:n,color:e,alpha:t,material:r}){return[n,e,t,r].filter(o=>o!==void 0)}function W1({faces:n}){return n.map(t=>{let r=we(t),o=r.map(({firstFrame:s,frameCount:i})=>s+i-1);return[Math.max(...r.map(({firstFrame:s})=>s)),Math.min(...o)]}).filter(([t,r])=>t<=r)}function as(n,e){return W1(n).some(([t,r])=>t<=e&&e<=r)}function Vc({isHalf:n,transfer:e,exposureEv:t}){return n?{name:"light"}:{name:"codes",transfer:e,exposureEv:t}}function Wc(n,e){let[t,r]=e.size,o=we(e).find(s=>s.width!==t||s.height!==r);if(o!==void 0)throw new g(`Probe ${n}, face ${e.face}: ${o.kind} has ${o.width}x${o.height} pixels and depth ${t}x${r}; rendering takes images of one size.`)}function cs({streams:n,probes:e}){let t=new Map(n.map(s=>[`${s.probe} ${s.face} ${s.kind}`,s])),r=new Map,o;for(let s of n){let{header:i,probe:a,face:c,width:u,height:l}=s,d=x=>t.get(`${a} ${c} ${x}`),f=d("color");if(i.kind!=="depth"||f?.header.kind!=="color")continue;let h=Vc(f.header);if(o??=h,JSON.stringify(o)!==JSON.stringify(h))throw new g("Colors of this container are coded in more than one way; the player takes one.");let{name:m,orientation:p,intrinsics:w}=e[a],y=[u,l],v=os(c,y,w),E={face:c,size:y,map:v,depth:s,header:i,color:f,alpha:d("alpha"),material:d("material")};if(Wc(m,E),me(p)===void 0)throw new g(`Probe ${m}: its orientation is no rotation.`);let $=r.get(a)??{probe:a,faces:[],...jc(n,a)};$.faces.push(E),r.set(a,$)}if(o===void 0)throw new g("No probe of this container has both color and depth, which rendering takes.");return{views:[...r.values()],coding:o}}function jc(n,e){let[t,r]=[1/0,0];for(let{header:o,probe:s}of n)s===e&&o.kind==="depth"&&(t=Math.min(t,o.range.nearM),r=Math.max(r,o.range.farM));return{nearM:t,farM:r}}function us(n,e,t){let r=n.map(({view:o,position:s})=>({view:o,distanceM:xt(s,e)}));return r.sort((o,s)=>o.distanceM-s.distanceM||o.view-s.view),r.slice(0,Math.max(t,1)).map(({view:o})=>o)}function qc(n){let e=n&32768?-1:1,[t,r]=[n>>10&31,n&1023];return t===31?r===0?e*(1/0):NaN:e*(t===0?r*2**-24:(1024+r)*2**(t-25))}function At(n){let e=n<0?32768:0,t=Math.abs(n);if(!(t<65520))return e|(Number.isNaN(n)?0:31743);let r=Math.max(Math.floor(Math.log2(t)),-14),o=t*2**(10-r),s=Math.floor(o),i=o-s,a=i>.5||i===.5&&s%2===1?s+1:s;return e|(r+14)*1024+a}function Kc(n){let e=n&32767;return e<31744?n:e>31744?0:n&32768|31743}function Xc(n,e){return e===1?n:e>0?At(Math.fround(qc(n)/Math.fround(e))):0}function He(n,e){let t=n/255;return e==="linear"?t:t<=.04045?t/12.92:((t+.055)/1.055)**2.4}function Yc(n,e){let t=n<=.0031308?n*12.92:1.055*n**.4166666666666667-.055;return Math.min(Math.round((e==="linear"?n:t)*255),255)}function Qc(n){let e=new Uint8Array(65536);for(let t=1;t<256;t+=1)for(let r=0;r<256;r+=1)e[t*256+r]=t===255?r:Yc(He(r,n)*255/t,n);return e}var Rt=class{#e;constructor(e,t){this.#e=e.name==="codes"&&t?Qc(e.transfer):void 0}of(e,t,r){let[o,s,i,a]=t,c=e.pixels instanceof Uint16Array,u=c?new Uint16Array(4*i*a):new Uint8Array(4*i*a);for(let l=0;l<a;l+=1){let d=3*((s+l-e.rect[1])*e.rect[2]+o-e.rect[0]),f=r&&(s+l-r.rect[1])*r.rect[2]+o-r.rect[0];for(let h=4*l*i;h<4*(l+1)*i;h+=4){let m=r&&f!==void 0?Math.min(r.pixels[f++],255):255;for(let p=0;p<3;p+=1){let w=e.pixels[d++];c?u[h+p]=Xc(Kc(w),m/255):u[h+p]=this.#e?.[m*256+w]??w}u[h+3]=c?At(m/255):m}}return u}};var Jc=2,Zc=.99;function eu(n){let e=new Map;for(let{probe:t,header:r}of n)r.kind==="depth"&&e.set(t,Math.min(r.range.nearM,e.get(t)??1/0));return e}var j1=class{constructor(e,t,r,o){this.image=e;this.stream=t;this.nearM=r;this.viewers=o;this.#e=Math.ceil(t.width/t.unitWidth),this.#t=Math.ceil(t.height/t.unitHeight),this.seen=new Uint8Array(this.#e*this.#t);let s=1;for(;s<Math.max(this.#e,this.#t);)s*=2;this.#r([0,0],s,0)}image;stream;nearM;viewers;seen;#e;#t;#r([e,t],r,o){let s=[Math.min(e+r,this.#e),Math.min(t+r,this.#t)],i=is(this.image,this.#o([e,t]),this.#o(s),{margin:Jc,nearM:Zc*this.nearM});for(let a=o;a<this.viewers.length;a+=1){let c=this.viewers[a].sight(i);if(c==="partly"&&r>1){this.#n([e,t],r/2,a);return}if(c!=="missed"){for(let u=t;u<s[1];u+=1)this.seen.fill(1,u*this.#e+e,u*this.#e+s[0]);return}}}#n([e,t],r,o){for(let[s,i]of[[0,0],[r,0],[0,r],[r,r]])e+s<this.#e&&t+i<this.#t&&this.#r([e+s,t+i],r,o)}#o([e,t]){let{width:r,height:o,unitWidth:s,unitHeight:i}=this.stream;return[Math.min(e*s,r),Math.min(t*i,o)]}},Ge=class{#e;#t;#r=[];#n=[];#o=new Map;constructor(e){this.#e=e,this.#t=eu(e.streams)}look(e){e.length===this.#r.length&&e.every((r,o)=>Yo(r,this.#r[o]))||(this.#r=e,this.#n=e.map(({eye:r,axes:o,half:[s,i]})=>new kt(Be(r,o,{u:[-s,s],v:[-i,i]},0))),this.#o.clear())}units(e){let t=this.#o.get(e.index)??this.#s(e);return this.#o.set(e.index,t),t}sees(e,t){return this.units(e)[t]===1}#s(e){let t=this.#e.probes[e.probe],o=(this.#e.footage.poses.get(t.name)??[]).length>0?void 0:ss(t,e.face,[e.width,e.height]);return o===void 0?new Uint8Array(this.#e.unitCount(e.index)).fill(1):new j1(o,e,this.#t.get(e.probe)??0,this.#n).seen}};function Mt({shown:n,next:[e,t]},r){return r===n||r>=e&&r<=t}function Tt(n,e,t,r){let o=n.chunkIndex(e,t,r);if(o<0)return;let s=n.placeOf(o)==="last"?-1:o+1;return{unit:t,frame:r,chunk:o,next:s}}function ee({container:n,store:e},t,r){let o=n.chunks[t],s=e.get(o);if(s===void 0){r.push(o);return}return{chunk:o,stored:s,area:n.areaOf(t)}}var ls=64<<20,tu=8,Ct=class{constructor(e){this.decoding=e}decoding;#e=new Map;#t=new Set;#r=[];#n=new Set;#o=new Map;#s=0;#i=new Set;show(e,t){this.#t=new Set(e.map(ge));let r=[],o=0;for(let i of e){if(o+=this.#a(i),o>ls||this.#i.has(i.chunk))continue;let a=ge(i),c=this.#e.get(a);c!==void 0&&this.#c(a,c),(c?.chunk!==i.chunk||c.frame!==i.frame)&&r.push(i)}let s=i=>this.#o.get(ge(i))??-1;return this.#r=r.sort((i,a)=>s(i)-s(a)),this.#l(t),r.length}of(e,t){return this.#e.get(ge({stream:e,unit:t}))}clear(){this.#e.clear(),this.#t.clear(),this.#r=[],this.#o.clear()}#a({stream:e,unit:t}){let[,,r,o]=this.decoding.container.unitRect(e,t);return r*o}#l(e){this.#r=this.#r.filter(t=>{if(this.#n.has(ge(t))||this.#n.size>=tu)return!0;let r=ee(this.decoding,t.chunk,e);return r!==void 0&&this.#f(t,r),r===void 0})}#f(e,t){let r=ge(e),{chunk:o,frame:s}=e;this.#n.add(r),this.#o.set(r,this.#s+=1);let i=()=>this.#t.has(r),a=l=>{l!==void 0&&i()&&(this.#c(r,{chunk:o,frame:s,bytes:l}),this.#u())},c=()=>{this.#i.add(o)};this.decoding.pool.codings(t,s-t.chunk.firstFrame,i).then(a,c).then(()=>{this.#n.delete(r),this.#l([]),this.decoding.onReady()})}#c(e,t){this.#e.delete(e),this.#e.set(e,t)}#u(){let e=[...this.#e.values()].reduce((t,r)=>t+r.bytes.length,0);for(let[t,r]of this.#e){if(e<=ls)return;this.#e.delete(t),e-=r.bytes.length}}};function ge({stream:n,unit:e}){return`${n} ${e}`}var ru=8;function ds(n,{axes:e,half:t},r){let{views:o,coding:s,nearest:i,nearM:a,farM:c}=n;return{kind:"render",request:{camera:{axes:e,half:t},coding:s,nearM:a,farM:c,refine:ru,...r},views:o.map(({view:u,streams:l,fromEye:d,turn:f,cameraWeight:h})=>({view:u,fromEye:d,turn:f,cameraWeight:h,nearM:l.nearM})),nearest:i}}var nu=Uint8Array.from({length:4097},(n,e)=>{let t=e/4096;return Math.round(255*(t<=.0031308?12.92*t:1.055*t**.4166666666666667-.055))});function hs(n){return nu[Math.round(4096*Math.min(Math.max(n,0),1))]}function ou(n,e){let t=Math.max(n,0);switch(e){case"none":return t;case"reinhard":return t/(1+t);case"filmic":return t*(2.51*t+.03)/(t*(2.43*t+.59)+.14)}}function fs({rgba:n},{exposureEv:e,toneMap:t,marksHoles:r}){let o=new Uint8ClampedArray(n.length),s=2**e;for(let i=0;i<n.length;i+=1){if(i%4===3){o[i]=255;continue}let a=Math.min(Math.max(n[i-i%4+3],0),1),c=r&&i%4!==1?1:0;o[i]=hs(ou(c+a*(s*n[i]-c),t))}return o}function su(n,{rgba:e},t){for(let r=0;r<n.length;r+=1)r%4<3&&(n[r]=n[r]+t*(hs(e[r])-n[r]))}function ms(n,{eyes:[e,t],overlay:r},o){let s=n.getContext("2d");if(s===null)throw new Error("The canvas cannot be drawn to.");let[i,a]=e.size,c=fs(e,o),u=o.stereo==="side-by-side";[n.width,n.height]=o.size;let l=t&&fs(t,o);if(l!==void 0&&!u)for(let d=0;d<c.length;d+=4)c[d+1]=l[d+1],c[d+2]=l[d+2];[c,u?l:void 0].forEach((d,f)=>{d!==void 0&&(r!==void 0&&su(d,r,o.overlayShare),s.putImageData(new ImageData(d,i,a),f*(n.width-i),0))})}var iu=.01,ps=.1,bs=1e-18;function au({orientation:n}){let e=qo(me(n)??[0,0,0,1]);return[pe(e,[1,0,0]),pe(e,[0,1,0]),pe(e,[0,0,1])]}function cu({faces:n}){let e=n.flatMap(({size:[t,r],map:o})=>[0,t-1].flatMap(s=>[0,r-1].map(i=>St(o,s,i))));return Math.max(1,...e)}function Ot({views:n,coding:e},t,r,o){let s=u=>[Math.fround(u[0]),Math.fround(u[1]),Math.fround(u[2])],i=t.map(u=>{let l=n[u],d=o(l.probe);return{view:u,streams:l,fromEye:s(z(d.position,r)),turn:au(d),cameraWeight:1}}),a=i.map(({fromEye:u})=>T(u)),c=Math.max(0,...a);return c>0&&i.forEach((u,l)=>u.cameraWeight=1/(a[l]/c+iu)),{views:i,coding:e,nearest:a.indexOf(Math.min(...a)),nearM:Math.min(...i.map(({streams:u})=>u.nearM)),farM:Math.max(...i.map(({streams:u},l)=>a[l]+u.farM*cu(u)))}}function ws({nearM:n,farM:e},t,r){return uu(t,n/10,e,r)}function gs({distancesM:n}){let e=2**Math.ceil(Math.log2(n.length));return{longest:e,first:Math.max(e/4,1)}}function uu(n,e,t,r){let[o,s]=[Math.fround(e),Math.fround(t)],i=Math.log(s/o)/n,a=s>o?Float32Array.from({length:n+1},(u,l)=>o*Math.exp(i*l)):Float32Array.of(o),c=a.length>1?Math.log(a[1]/a[0]):0;return{distancesM:a,logStep:c,uncertainty:-Math.log1p(Math.expm1(-c)*.5**r)}}var q1=["none","raw","biquadratic","platelet","bc4w","values","one value","blocks","background","plane","changed plane","quarters","pixels"],ys=63,_s=64,vs=128,c5=Object.fromEntries(q1.map((n,e)=>[n,e]));var K1=[{color:[213,94,0],codings:["raw","values","pixels"],name:"Raw codes; pixel by pixel"},{color:[240,228,66],codings:["biquadratic","plane"],name:"Biquadratic; plane carried on"},{color:[0,114,178],codings:["platelet","changed plane"],name:"Platelet; plane with a change"},{color:[204,121,167],codings:["bc4w","blocks","quarters"],name:"BC4w or BC5 block; quarters"},{color:[0,158,115],codings:["one value","background"],name:"One value; background"}],lu=.45,du=.3;function xs(){return Array.from({length:256},(n,e)=>{let t=q1[e&ys],r=K1.find(({codings:s})=>s.includes(t)),o=((e&_s)!==0?lu:1)*((e&vs)!==0?du:1);return r?.color.map(s=>Math.round(s*o))})}var X1=[18,20,26],fu=[255,255,255],hu=[255,176,0],ks=[60,220,90],mu=[255,120,40],pu=[40,90,200],bu=["probes","nodes","units","keyframes","fetched"],Pt={name:"codes",transfer:"srgb",exposureEv:0},Nt=.55;function Ft({overlays:n}){return bu.filter(e=>n.has(e))}var ye=class{constructor(e,t,r){this.container=e;this.catalogue=t;this.send=r}container;catalogue;send;#e=new Map;#t=Uint32Array.from(xs(),e=>e===void 0?0:ze(e));forget(e){this.catalogue.views[e].faces.forEach(({depth:t})=>this.#e.delete(t.index))}paint(e,t){for(let r of t.views)for(let o of this.catalogue.views[r].faces){let s=new Y1(o.size);e.forEach(i=>this.#r(i,{view:r,streams:o},t,s));for(let i of s.changesTo(this.#e.get(o.depth.index)))this.send({view:r,face:o.face},i,s.texels(i));s.forgetMaps(),this.#e.set(o.depth.index,s)}}#r(e,{view:t,streams:r},{view:{frame:o},isFresh:s,codings:i},a){let{depth:c,color:u}=r;e==="probes"?a.fill([0,0,...r.size],wu(t/this.catalogue.views.length)):e==="nodes"?this.#n(c,(l,d)=>{let f=i(c.index,d),h=f===void 0?"":`${f.chunk} ${f.frame}`;a.map(l,{key:h,bytes:f?.bytes,words:this.#t})}):e==="units"?(this.#n(u,l=>a.frame(l,hu)),this.#n(c,l=>a.frame(l,fu))):(this.#n(c,(l,d)=>{let f=this.container.chunkIndex(c.index,d,o);if(!(f<0))if(e==="fetched")a.fill(l,s(f)?ks:X1);else{let{firstFrame:h,frameCount:m}=this.container.chunks[f],p=(o-h)/Math.max(1,m-1);a.fill(l,mu.map((w,y)=>Math.round(w+(pu[y]-w)*p)))}}),e==="fetched"&&this.#n(u,(l,d)=>{let f=this.container.chunkIndex(u.index,d,o);f>=0&&s(f)&&a.frame(l,ks)}))}#n({index:e},t){for(let r=0;r<this.container.unitCount(e);r+=1)t(this.container.unitRect(e,r),r)}};function wu(n){let e=t=>Math.round(255*(.55+.4*Math.cos(2*Math.PI*(n-t))));return[e(0),e(1/3),e(2/3)]}var Y1=class{constructor(e){this.size=e}size;#e=[];get#t(){return this.#e.map(({rect:e,color:t,isFrame:r})=>[...e,...t,r].join()).join(" ")}changesTo(e){return e===void 0||e.#t!==this.#t?[[0,0,...this.size]]:this.#e.filter(({map:t},r)=>t?.key!==e.#e[r].map?.key).map(({rect:t})=>t)}fill(e,t){this.#e.push({rect:e,color:t,isFrame:!1})}frame(e,t){this.#e.push({rect:e,color:t,isFrame:!0})}map(e,t){this.#e.push({rect:e,color:X1,isFrame:!1,map:t})}forgetMaps(){this.#e.forEach(({map:e})=>e&&(e.bytes=void 0))}texels(e){let[t,r,o,s]=e,i=new Uint8Array(4*o*s),a=new Uint32Array(i.buffer);a.fill(ze(X1));for(let c of this.#e){let[u,l,d,f]=c.rect,[h,m]=[Math.max(u,t),Math.min(u+d,t+o)];for(let p=Math.max(l,r);p<Math.min(l+f,r+s)&&h<m;p+=1){let w=(p-r)*o+h-t;gu(c,p,[h,m],a.subarray(w,w+m-h))}}return i}};function gu(n,e,[t,r],o){let[s,i,a,c]=n.rect;if(n.map!==void 0){let{bytes:u,words:l}=n.map,d=(e-i)*a+t-s;for(let f=0;u!==void 0&&f<o.length;f+=1)o[f]=l[u[d+f]]||o[f]}else!n.isFrame||e===i||e===i+c-1?o.fill(ze(n.color)):(t===s&&(o[0]=ze(n.color)),r===s+a&&(o[o.length-1]=ze(n.color)))}function ze([n,e,t]){return(n|e<<8|t<<16|255<<24)>>>0}function $e({view:{size:n,stereo:e}}){return[e==="side-by-side"?Math.ceil(n[0]/2):n[0],n[1]]}function yu(n,e){let[t,r]=[Math.max(n[0],e[0]),Math.max(n[1],e[1])],[o,s]=[Math.min(n[0]+n[2],e[0]+e[2]),Math.min(n[1]+n[3],e[1]+e[3])];return t<o&&r<s?[t,r,o-t,s-r]:void 0}function Ut(n,e){if(n===void 0)return e;let[t,r]=[Math.min(n[0],e[0]),Math.min(n[1],e[1])],[o,s]=[Math.max(n[0]+n[2],e[0]+e[2]),Math.max(n[1]+n[3],e[1]+e[3])];return[t,r,o-t,s-r]}function Es(n,e){let t=n===0?1:0,r=[...e].sort((s,i)=>s[t]-i[t]||s[n]-i[n]),o=[];for(let s of r){let i=o.at(-1);i!==void 0&&i[t]===s[t]&&i[t+2]===s[t+2]&&i[n]+i[n+2]===s[n]?i[n+2]+=s[n+2]:o.push([...s])}return o}function Ss(n){return Es(1,Es(0,n))}function*_e(n,e){let{width:t,unitWidth:r,unitHeight:o}=n,[s,i,a,c]=e,u=Math.ceil(t/r);for(let l=Math.floor(i/o);l*o<i+c;l+=1)for(let d=Math.floor(s/r);d*r<s+a;d+=1){let f=yu(S(n,l*u+d),e);f!==void 0&&(yield[l*u+d,f])}}var Lt=class{constructor(e){this.stream=e;this.#e=new Uint8Array(N(e))}stream;#e;isKnown(e){return this.#e[e]===1}setKnown(e,t){let r=this.#e[e];return this.#e[e]=Number(t),r!==Number(t)}},ve=class{constructor(e){this.streams=e;this.depth=new Lt(e.depth),this.others=[e.color,e.alpha,e.material].filter(t=>t!==void 0).map(t=>new Lt(t))}streams;depth;others;#e=new Set;#t=[];setKnown(e,t,r){let o=e.setKnown(t,r);e===this.depth&&r?this.#e.add(t):o&&this.#t.push(S(e.stream,t))}takeParts(){let e=new Map;for(let t of this.#e)e.set(t,[S(this.streams.depth,t)]);for(let t of this.#t)for(let[r,o]of _e(this.depth.stream,t))this.#e.has(r)||e.set(r,[...e.get(r)??[],o]);return this.#e.clear(),this.#t=[],[...e].flatMap(([t,r])=>this.#r(t,r))}#r(e,t){let r=t.map(s=>({rect:s,isKnown:this.depth.isKnown(e)}));for(let s of this.others)r=r.flatMap(({rect:i,isKnown:a})=>[..._e(s.stream,i)].map(([c,u])=>({rect:u,isKnown:a&&s.isKnown(c)})));let o=[...new Map(r.map(s=>[s.rect.join(),s])).values()];return[!0,!1].flatMap(s=>{let i=o.filter(a=>a.isKnown===s).map(({rect:a})=>a);return Ss(i).map(a=>({rect:a,tile:e,isKnown:s}))})}},xe=class{#e=new Map;#t=new Map;load(e,t){this.#e.set(e,t);for(let r of t)[r.depth,...r.others].forEach(o=>this.#t.set(o.stream.index,{face:r,units:o}))}unload(e){let t=this.ofView(e);for(let{depth:r,others:o}of t)[r,...o].forEach(({stream:s})=>this.#t.delete(s.index));return this.#e.delete(e),t}views(){return this.#e.entries()}ofView(e){let t=this.#e.get(e);if(t===void 0)throw new Error(`View ${e} is not loaded`);return t}ofStream(e){let t=this.#t.get(e);if(t===void 0)throw new Error(`Stream ${e} is of no loaded view`);return t}isKnown(e,t){return this.ofStream(e).units.isKnown(t)}setKnown(e,t,r){let{face:o,units:s}=this.ofStream(e);o.setKnown(s,t,r)}};var Q1=class extends ve{constructor(t,r,o){super(t);this.view=r;this.codes=o}view;codes},It=class{constructor(e,t){this.catalogue=e;this.send=t}catalogue;send;#e=new xe;load(e,t){let{faces:r}=this.catalogue.views[e];this.#e.load(e,r.map(s=>new Q1(s,e,t)));let o=r.map(({face:s,size:i,map:a,header:{range:c,isDistance:u}})=>({face:s,size:i,map:a,range:c,isDistance:u}));this.send({kind:"load",view:e,faces:o,isLight:this.catalogue.coding.name==="light"})}unload(e){this.#e.unload(e),this.send({kind:"unload",view:e})}isKnown(e,t){return this.#e.isKnown(e,t)}written(e,t){this.#e.setKnown(e,t,!0)}forget(e,t){this.#e.setKnown(e,t,!1)}uploadColor(e,t,r){let{view:o,streams:s}=this.#e.ofStream(e).face;this.send({kind:"color",area:{view:o,face:s.face,rect:t},texels:r})}uploadMaterial(e,t){this.written(e,t)}isSpecular(){return!1}update(){for(let[e,t]of this.#e.views())for(let r of t){let{depth:o,face:s}=r.streams;for(let{rect:i,tile:a,isKnown:c}of r.takeParts()){let u=c?_u(r.codes(o.index,a),S(o,a),i):void 0;this.send({kind:"depth",area:{view:e,face:s,rect:i},codes:u})}}}};function _u(n,[e,t,r],o){let s=new Uint16Array(o[2]*o[3]);for(let i=0;i<o[3];i+=1){let a=(o[1]-t+i)*r+o[0]-e;s.set(n.subarray(a,a+o[2]),i*o[2])}return s}var vu=320*180,xu=128,Bt=class{constructor(e){this.scene=e;this.#e=new Worker(new URL("./cpu_worker.js",import.meta.url),{type:"module"}),this.#e.onmessage=({data:r})=>{this.#r?.resolve(r),this.#r=void 0},this.#e.onerror=({message:r})=>this.#s(r??"it did not load"),this.#e.onmessageerror=()=>this.#s("its answer cannot be read");let t=r=>this.#e.postMessage(r);this.texels=new It(e.catalogue,t),this.#t=new ye(e.container,e.catalogue,(r,o,s)=>{t({kind:"overlay",area:{...r,rect:o},texels:s})})}scene;texels;name="cpu";mostPixels=vu;hasEffects=!1;onFailed=()=>{};#e;#t;#r;#n;#o={size:[0,0],rgba:new Float32Array};load(e,t,r){return this.#t.forget(e),this.texels.load(e,(o,s)=>r(o,s)),Promise.resolve([])}async draw(e,t){let{view:r,cameras:o}=e,s=[];for(let f of o)s.push(await this.#a(e,f,!1));let i=$e(e),a=Ft(r),c;a.length>0&&(this.#t.paint(a,e),c={size:i,rgba:(await this.#a(e,o[0],!0)).rgba});let u=s.map(({rgba:f})=>({size:i,rgba:f}));[this.#o]=u;let l={...r,marksHoles:r.overlays.has("holes"),overlayShare:Nt};ms(this.scene.canvas,{eyes:u,overlay:c},l),t();let[{counts:d}]=s;return{counters:{...d},decodeMs:0,marchMs:s.reduce((f,{ms:h})=>f+h,0)}}decodeMs(){return Promise.resolve(0)}pixels(){let{size:e,rgba:t}=this.#o;return Promise.resolve({size:[...e],rgba:t})}close(){this.#e.terminate(),this.#i("The film was closed.")}#s(e){let t=`The worker that renders failed: ${e}`;this.#i(t),this.onFailed(t)}#i(e){this.#n??=e,this.#r?.reject(new Error(e)),this.#r=void 0}#a(e,t,r){let{container:o,catalogue:s}=this.scene,{view:i,views:a}=e,c=Ot(s,a,t.eye,d=>o.probeAt(d,i.frame)),u=r?Pt:c.coding,l=ds({...c,coding:u},t,{size:$e(e),steps:Math.min(i.steps,xu),showsOverlay:r,looksBehindHoles:!i.overlays.has("holes")});return new Promise((d,f)=>{if(this.#n!==void 0)throw new Error(this.#n);this.#r?.reject(new Error("Another picture was ordered.")),this.#r={resolve:d,reject:f},this.#e.postMessage(l)})}};function Dt(n,e){let{keyframes:t,weights:r}=n,[o,s]=[0,t.length];for(;o<s;){let c=o+s>>1;t[c]<=e?o=c+1:s=c}let i=Math.max(o-1,0),a=e<r.length?r[e]:0;return{keyframe:i,weight:a,needsNext:a>0&&i+1===t.length}}function J1(n,e,t,r){if(t===void 0)return r;let{frameSets:o,framePixels:s}=n;if(s.length===0){let[c,u]=[Dt(n,t),Dt(n,e)];return c.keyframe===u.keyframe&&c.weight===u.weight?0:r}let i=(c,u)=>(o[4*c+(u>>5)]>>>(u&31)&1)===1,a=0;for(let c=0;c<s.length;c++)i(c,e)&&!i(c,t)&&(a+=s[c]);return a}var Rs=Int32Array.of(362,362,362,362,361,361,360,360,359,358,357,356,355,354,353,351,350,348,346,345,343,341,339,337,334,332,330,327,325,322,319,316,314,311,307,304,301,298,294,291,287,284,280,276,272,268,264,260,256,252,247,243,239,234,230,225,220,216,211,206,201,196,191,186,181,176,171,165,160,155,149,144,139,133,128,122,116,111,105,99,94,88,82,76,71,65,59,53,47,41,35,30,24,18,12,6,0),ku=8,te=[1,2,3,4,6,8,12,16,24];var Eu=Uint8Array.from({length:97},(n,e)=>{let t=te.indexOf(e);return t<0?te.length:t});function Z1(n){return Eu[n]}function er(n,e,t){if(e===0)return 1<<ku;let r=(2*t+1)*e*(96/n)%384,o=r>192?384-r:r;return o>96?-Rs[192-o]:Rs[o]}var O5=te.map(As),P5=[4,8,16,32].map(As);function As(n){return Int32Array.from({length:n*n},(e,t)=>er(n,t%n,Math.floor(t/n)))}var Su=[0,1,2,2,3,3,3,4,4,4,4,4],tr=[4,8,16,32].map(n=>{let e=[];for(let t=0;t<2*n-1;t++)for(let r=0;r<=t;r++){let o=t%2===1?r:t-r;o<n&&t-o<n&&e.push([t-o,o])}return{places:Uint16Array.from(e,([t,r])=>32*r+t),magnitudes:Uint16Array.from(e,([t,r])=>34*r+t),classes:Uint8Array.from(e,([t,r])=>Su[t+r]??5)}});var Ht=Uint8Array.of(0,1,2,3,4,5,5,6,6,6,6,7),z5=Ht.length-1;var Ms=[4096,4277,4467,4664,4871,5087,5312,5547,5793,6049,6317,6597,6889,7194,7512,7845],Ts=[4096,2896,2365,2048,1672,1448,1182,1024,836],rr=[new Uint8Array(128),Uint8Array.of(1,3,5,7,8,9,10,10,11,12,12,13,13,14,14,15,15,15,16,16,16,17,17,17,18,18,18,18,19,19,19,19,19,20,20,20,20,20,21,21,21,21,21,21,22,22,22,22,22,22,22,23,23,23,23,23,23,23,23,24,24,24,24,24,2,5,8,10,12,14,15,16,18,19,20,20,21,22,23,23,24,25,25,26,26,27,27,28,28,29,29,29,30,30,30,31,31,31,32,32,32,33,33,33,34,34,34,34,35,35,35,35,36,36,36,36,36,37,37,37,37,37,38,38,38,38,38,38)];var Ru=-8,Au=-Ru;var Cs=96;var Mu=32,Os=118,sh=Os*16;function Ps(n){let e=n.flatMap(({coding:s})=>s.name==="transform"?[s.tables]:[]);if(e.length===0)return{words:new Uint32Array,firstSets:[]};let t=Ou(),r=[],o=e.map(s=>{let i=r.find(c=>Tu(c.tables,s));if(i!==void 0)return i.first;let a=t.length;return r.push({tables:s,first:a}),co(s).forEach(c=>Cu(t,c)),a});return{words:Uint32Array.from(t),firstSets:o}}function Tu(n,e){return n.own.length===e.own.length&&n.own.every(({starts:t},r)=>t.every((o,s)=>o===e.own[r].starts[s]))}function Cu(n,{starts:e}){for(let t=0;t<Os;t++){let r=t*17;for(let o=0;o<16;o++)n.push(e[r+o]|e[r+o+1]<<16)}}function Ou(){let n=tr.flatMap(({places:i,classes:a})=>Array.from(i,(c,u)=>c|a[u]<<16)),e=Array.from(rt().distributionOf,i=>i*16),t=Array(Cs+1).fill(te.length),r=[...Ms,...Ts,...rr.flatMap(i=>[...i])],o=t.length+Ht.length+n.length+e.length+r.length,s=[];for(let i of[...te,Mu]){t[i]=Z1(i)|o+s.length<<8;for(let a=0;a<i*i;a++)s.push(er(i,Math.floor(a/i),a%i)>>>0)}return[...t,...Ht,...n,...e,...r,...s]}function Ns(n,e,t,r){if(e===t)return[];if(r===0)return[nr(n,t)-1];let o=e===void 0||e>t,s=o?[0]:[],i=o?0:e;for(;i<t;){let a=nr(n,i),c=Math.min(a<n.length?n[a]:t,t);i+=Math.floor((c-i-1)/r)*r,i+=Math.min(r,t-i);let u=nr(n,i)-1;n[u]===i&&s.push(u)}return s}function nr(n,e){let t=0,r=n.length;for(;t<r;){let o=t+r>>>1;n[o]<=e?t=o+1:r=o}return t}var Pu={bc1:"cells-bc1",bc7:"cells-bc7",bc6h:"cells-bc6h"};function Nu(n){switch(n.kind){case"alpha":throw new g("Alpha is not decoded on the graphics device.");case"material":return n.inBlocks?"boxes-bc1":"boxes-material";case"depth":switch(n.coding.name){case"boxes":return n.coding.inBlocks?"boxes-bc5":"boxes-codes";case"predictive":return"boxes-codes";default:return"nodes"}case"color":return n.coding.name==="transform"?n.isHalf?"transform-half":"transform-8bit":n.coding.blocks!==void 0?Pu[n.coding.blocks]:n.isHalf?"cells-half":"cells-8bit"}}function ke(n){let e=Nu(n);if(n.kind!=="color")return{kernel:e,keyframes:void 0,plan:"plan-records",words:n.kind==="material"?"bytes":"codes",isColor:!1};let t=n.isHalf?"cells-half":"cells-8bit";return{kernel:e,keyframes:n.coding.name==="transform"?t:void 0,plan:"plan-cells",words:n.isHalf?"halves":"bytes",isColor:!0}}function Gt(n,e,t){switch(n.words){case"codes":return Math.ceil(e/2);case"halves":return 2*e;case"bytes":return n.isColor?Math.ceil(e/t)*t:e}}function Fs(n,e){let t=ke(n.header),r=Math.min(n.unitWidth,n.width);return(Math.floor(n.width/r)*Gt(t,r,e)+Gt(t,n.width%r,e))*n.height}function Us(n){let e={window:0,domain:0,base:0,scale:0};if(n.kind==="material")return{...e,window:n.window};if(n.kind!=="depth")return e;let{coding:t}=n;switch(t.name){case"boxes":return{...e,window:t.window};case"predictive":return{...e,window:1};case"nodes":return{window:t.window,domain:t.domain.kind,base:t.domain.base,scale:t.domain.scale};case"blocks":return e}}var F=Oe.constants,zt=2,Fu={u32:["u32",1,1],i32:["i32",1,1],f32:["f32",1,1],"vec2<f32>":["f32",2,2],"vec3<f32>":["f32",3,4],"array<u32, 8>":["u32",8,1]};function Uu(n){let e=new Map,[t,r]=[0,1];for(let o of n){let[s="",i=""]=o.split(": "),a=Fu[i];if(a===void 0)throw new Error(`shaders/kernels.json: ${i} is no type of a member`);let[c,u,l]=a,d=Math.ceil(t/l)*l;e.set(s,{scalar:c,offset:d,words:u}),t=d+u,r=Math.max(r,l)}return{members:e,words:Math.ceil(t/r)*r}}var Lu=new Map(Oe.structs.map(n=>[n.name,Uu(n.members)]));function Ls(n){let e=Lu.get(n);if(e===void 0)throw new Error(`shaders/kernels.json has no struct ${n}`);return e}function Is(n,e){let t=Ls(n).members.get(e);if(t===void 0)throw new Error(`shaders/kernels.json: ${n} has no member ${e}`);return t}function U(n){return Ls(n).words}function M(n,e){return Is(n,e).offset}function Ve(n,e,t,r){for(let[o,s]of Object.entries(r)){let{scalar:i,offset:a,words:c}=Is(t,o),u=typeof s=="number"?[s]:s;if(u.length!==c)throw new Error(`${t}.${o} has ${c} words and not ${u.length}`);i==="f32"?new Float32Array(n.buffer,n.byteOffset,n.length).set(u,e+a):n.set(u,e+a)}}function J(n,e){let t=U(n),r=new Uint32Array(e.length*t);return e.forEach((o,s)=>Ve(r,s*t,n,o)),r}function $t(n,e){let t=new Uint32Array(zt+e.length);return t.set(n),t.set(e,zt),t}var Iu=16384,Ee=class{label;buffer;bytesSent=0;#e;#t=0;#r=[];#n=0;constructor(e,t){this.#e=e,this.label=t,this.buffer=e.buffer(t,Iu)}get taken(){return this.#t-this.#n}hasRoom(e,t){return this.#r.some(r=>r.words>=e)||this.#t+e<=t}put(e){let t=this.#o(e.length);return this.#e.write(this.buffer,4*t,e),this.bytesSent+=e.byteLength,t}#o(e){let t;for(let o of this.#r)o.words>=e&&(t===void 0||o.words<t.words)&&(t=o);if(t!==void 0&&e>0){let{at:o}=t;return t.at+=e,t.words-=e,this.#n-=e,this.#r=this.#r.filter(s=>s.words>0),o}let r=this.#t;return this.#s(r+e),this.#t=r+e,r}#s(e){let t=this.buffer;if(4*e<=t.size)return;let r=Math.floor(this.#e.maxBindingBytes/4),o=Math.max(Math.min(2**Math.ceil(Math.log2(e)),r),e);this.buffer=this.#e.buffer(this.label,o),this.#e.submit(s=>s.copyBufferToBuffer(t,0,this.buffer,0,t.size)),this.#e.release(t)}free({at:e,words:t}){if(t===0)return;let r=this.#r.findIndex(l=>l.at>e),o=r<0?this.#r.length:r,[s,i]=[this.#r[o-1],this.#r[o]],a={at:e,words:t},[c,u]=[o,0];s!==void 0&&s.at+s.words===e&&(a.at=s.at,a.words+=s.words,c-=1,u+=1),i!==void 0&&i.at===e+t&&(a.words+=i.words,u+=1),this.#r.splice(c,u,a),this.#n+=t,a.at+a.words===this.#t&&(this.#r.pop(),this.#n-=a.words,this.#t=a.at)}destroy(){this.#e.release(this.buffer)}},re={words:U("Record"),at:M("Record","at"),first:M("Record","first"),work:M("Record","work")},or={words:U("BoxRow"),at:M("BoxRow","at")},Vt=U("Chunk"),sr=4;function Ds(n){return Math.ceil(n.length/sr)*sr}function Bu(n){if(n.length%sr===0)return n;let e=new Uint32Array(Ds(n));return e.set(n),e}function Bs(n,e,t){let r=n.slice();for(let[o,s]of t)for(let i=o;i<r.length;i+=e)r[i]+=s;return r}var Wt=class{#e;#t;#r;#n;#o=new Map;#s;constructor(e,t){this.#e=new Ee(e,"stream"),this.#t=new Ee(e,"records"),this.#r=new Ee(e,"boxes"),this.#n=new Ee(e,"chunks"),this.#s=t}get#i(){return[this.#e,this.#t,this.#r,this.#n]}buffer(e){return this.#i.find(t=>t.label===e)?.buffer}chunk(e){return this.#o.get(e)}get streamWords(){return this.#e.taken}get bytes(){return this.#i.reduce((e,t)=>e+t.buffer.size,0)}get bytesSent(){return this.#i.reduce((e,t)=>e+t.bytesSent,0)}hasRoom({stream:e,records:t,boxes:r}){let o=[Ds(e),t.length,r.length,Vt];return this.#i.every((s,i)=>s.hasRoom(o[i]??0,this.#s))}place(e,t,r){let o=Bu(t.stream),s=this.#e.put(o),i=Bs(t.boxes,or.words,[[or.at,4*s]]),a=this.#r.put(i),c=Bs(t.records,re.words,[[re.at,t.isNodes?s:4*s],[re.first,a/or.words]]),u=this.#t.put(c),[l,d]=t.weights,f=new Uint32Array(Vt);Ve(f,0,"Chunk",{first_record:u/re.words,record_count:c.length/re.words,weights_at:l+4*s,weight_count:d});let h=this.#n.put(f),m=0;for(let p=re.work;p<c.length;p+=re.words)m=Math.max(m,c[p]??0);this.#o.set(e,{row:h/Vt,mostWork:m,kernel:t.kernel,passes:t.passes,timeline:t.timeline,lastUsed:r,places:[{at:s,words:o.length},{at:u,words:c.length},{at:a,words:i.length},{at:h,words:Vt}]})}drop(e,t){let r=[...this.#o].filter(([o])=>!e.has(o));r.sort(([o,{lastUsed:s}],[i,{lastUsed:a}])=>s-a||o-i);for(let[o,{places:s}]of r){if(this.streamWords<=t)return;this.#o.delete(o),this.#i.forEach((i,a)=>i.free(s[a]??{at:0,words:0}))}}destroy(){this.#i.forEach(e=>e.destroy()),this.#o.clear()}};var Du=64,Hu=16384,Gu=2**31,zu=2**27,W={words:U("Unit"),picture:M("Unit","picture"),width:M("Unit","width"),height:M("Unit","height"),stride:M("Unit","stride"),window:M("Unit","window")};function $u(n,e,t,r){let o=[],s=new Uint32Array(n.reduce((c,u)=>c+N(u),0)*W.words),[i,a]=[0,0];return n.forEach((c,u)=>{o.push(i);let l=Us(c.header),d=t[u]??l.base;for(let f=0;f<N(c);f+=1){let[,,h,m]=S(c,f),p=Gt(e,h,r);Ve(s,i*W.words,"Unit",{...l,base:d,picture:a,width:h,height:m,stride:p}),a+=p*m,i+=1}}),{firstUnits:o,rows:s}}function Vu(n,e){return n.reduce((t,r)=>t+Fs(r,e),0)}function Wu(n,{reader:e}){let t=n.map(({width:r,height:o,unitWidth:s,unitHeight:i})=>Math.ceil(Math.min(s,r)/32)*Math.ceil(Math.min(i,o)/32));return e===void 0?0:Math.max(0,...t)*F.SCRATCH_WORDS}var jt=class n{streams;family;pictures;pixelsWritten=0;pixelsWanted=0;#e;#t;#r;#n;#o=new Map;#s;#i;#a;#l;#f=0;#c=0;constructor(e,t,r,o,s){let i=ke(t[0].header),a=Ps(t.map(({header:l})=>l).filter(l=>l.kind==="color")),c=Vu(t,s),u=t.reduce((l,d)=>l+N(d),0);e.check("pictures",c),e.check("scratch",Wu(t,o.codec)),e.check("units",u*W.words),this.#e=e,this.streams=t,this.family=i,this.#t=r,this.#r=o,this.#n=$u(t,i,a.firstSets,s),this.pictures=e.buffer("pictures",c),this.#i={units:e.filled("units",this.#n.rows),states:e.buffer("states",u*U("State")),log2_table:e.filled("log2_table",ho),tables:e.filled("tables",a.words),dispatch:e.buffer("dispatch",U("Dispatch"),GPUBufferUsage.INDIRECT)},this.#a=e.buffer("items",0),this.#l=e.buffer("jobs",0),this.#s=new Wt(e,Math.floor(e.maxBindingBytes/4))}static async create(e,t,r=1){let[o,...s]=t.map(l=>ke(l.header));if(o===void 0||s.some(({kernel:l})=>l!==o.kernel))throw new O("Streams of different families cannot be decoded together.");let i=async l=>{let{reader:d}=se(l),[f,h]=await Promise.all([e.pipeline(l),d===void 0?void 0:e.pipeline(d)]);return{kernel:f,reader:h}},[a,c,u]=await Promise.all([e.pipeline(o.plan),i(o.kernel),i(o.keyframes??o.kernel)]);return new n(e,t,a,{codec:c,keyframes:u},r)}has(e){return this.#s.chunk(e)!==void 0}add(e,t){return this.has(e)?!0:this.#s.hasRoom(t)?(this.#s.place(e,t,this.#c),!0):!1}drop(e,t){this.#s.drop(e,t)}get chunkWords(){return this.#s.streamWords}get bytes(){let e=[this.pictures,this.#a,this.#l,...Object.values(this.#i)];return this.#s.bytes+e.reduce((t,r)=>t+r.size,0)}get bytesSent(){return this.#s.bytesSent+this.#f}needsNext({key:e,frame:t,firstFrame:r}){let o=this.#s.chunk(e);return this.family.isColor&&o!==void 0&&Dt(o.timeline,t-r).needsNext}shows(e){let t=this.#o.get(this.#u(e.stream,e.unit));if(t?.key!==e.key)return!1;let r=e.frame-e.firstFrame;return t.frame===r||this.family.isColor&&J1(t.timeline,r,t.frame,1)===0}showsAny(e,t){return this.#o.has(this.#u(e,t))}unit(e,t){let r=this.#u(e,t)*W.words,o=s=>this.#n.rows[r+s]??0;return{picture:o(W.picture),stride:o(W.stride),width:o(W.width),height:o(W.height)}}decode(e,t){this.#c+=1;let r={written:[],pixels:0,missing:[],behind:[],refused:[]},o=[];for(let s of e){let{width:i,height:a}=this.unit(s.stream,s.unit);this.pixelsWanted+=i*a,this.#d(s,o,r)}return this.pixelsWritten+=r.pixels,o.forEach(s=>this.#x(s,t)),r}destroy(){this.#s.destroy(),[this.pictures,this.#a,this.#l,...Object.values(this.#i)].forEach(e=>this.#e.release(e))}#u(e,t){return(this.#n.firstUnits[e]??0)+t}#d(e,t,r){let o=this.#u(e.stream,e.unit),s=e.frame-e.firstFrame,i=this.#o.get(o);if(i?.key===e.key&&i.frame===s)return;let a=this.#s.chunk(e.key),c=this.needsNext(e)?this.#s.chunk(e.nextKey??0):a;if(a===void 0||c===void 0){r.missing.push(e);return}a.lastUsed=this.#c,c.lastUsed=this.#c;let u=this.#m(e,a.timeline);if(u===void 0){r.refused.push(e);return}let l=t.findLast(({kernel:d})=>d===a.kernel);(l===void 0||l.work+a.mostWork>this.#h(a.kernel))&&(l={kernel:a.kernel,items:[],rounds:0,passes:0,work:0},t.push(l)),l.items.push({unit:o,chunk:a.row,next:c===a?F.NONE:c.row,frame:s,key:e.key}),l.work+=a.mostWork,l.rounds=Math.max(l.rounds,u.rounds),l.passes=Math.max(l.passes,a.passes),this.#o.set(o,{key:e.key,frame:u.reached,timeline:a.timeline}),r.pixels+=u.pixels,r.written.push({wanted:e,pixels:u.pixels}),u.reached!==s&&r.behind.push(e)}#h(e){return this.#r[e].reader===void 0?Gu:Math.floor(Math.min(zu,this.#e.maxBindingBytes)/(4*F.SCRATCH_WORDS))}#m(e,t){let r=this.#u(e.stream,e.unit),o=this.#o.get(r),s=o?.key===e.key?o.frame:void 0,i=e.frame-e.firstFrame,{width:a,height:c}=this.unit(e.stream,e.unit),u=a*c;if(this.family.isColor)return{rounds:1,pixels:J1(t,i,s,u),reached:i};let l=this.#n.rows[r*W.words+W.window]??0;if(l===0)return{rounds:1,pixels:u,reached:i};let d=Ns(t.recordFrames,s,i,l);if(d.length>Hu)return;let f=d.slice(0,Du),h=f.at(-1),m=f.length<d.length&&h!==void 0;return{rounds:Math.max(f.length,1),pixels:f.reduce((p,w)=>p+(t.recordPixels[w]??0),0),reached:m?t.recordFrames[h]??i:i}}#x({kernel:e,items:t,rounds:r,passes:o,work:s},i){let a=$t([t.length,0],J("Item",t));this.#a=this.#b(this.#a,a.length),this.#l=this.#b(this.#l,zt+t.length*U("Job")),this.#e.write(this.#a,0,a),this.#f+=a.byteLength;let{reader:c,kernel:u}=this.#r[e];c!==void 0&&this.#e.scratch(s*F.SCRATCH_WORDS);let[l,d]=[0,4*M("Dispatch","part_x")],f=[...c===void 0?[]:[{...c,times:o,size:l}],{...u,times:1,size:c===void 0?l:d}].map(m=>({...m,group:this.#p(m)})),h=this.#p(this.#t);this.#e.submit(m=>{let p=m.beginComputePass(i===void 0?{}:{timestampWrites:i});for(let w=0;w<r;w+=1){p.setPipeline(this.#t.pipeline),p.setBindGroup(0,h),p.dispatchWorkgroups(1);for(let{pipeline:y,group:v,times:E,size:$}of f){p.setPipeline(y),p.setBindGroup(0,v);for(let x=0;x<E;x+=1)p.dispatchWorkgroupsIndirect(this.#i.dispatch,$)}}p.end()})}#b(e,t){if(4*t<=e.size)return e;let r=this.#e.buffer(e.label,t);return this.#e.release(e),r}#p(e){let t={...this.#i,items:this.#a,jobs:this.#l,scratch:this.#e.scratch(0),pictures:this.pictures};return this.#e.bind(e,r=>{let o=t[r]??this.#s.buffer(r);if(o===void 0)throw new O(`No buffer of a decoder is named ${r}.`);return{buffer:o}})}};function Hs({nearM:n,farM:e}){let t=Math.log(e/n),r=new Float32Array(65536);for(let o=0;o<65534;o+=1)r[o]=1/Math.fround(n*Math.exp(t*o/65534));return r[0]=1/n,r[65534]=1/e,new Uint32Array(r.buffer)}var Se=64,Gs=2139095040,zs=1900671690,ju=64,qu=[[0,6],[8,3],[11,2],[13,1]],cr=13,$s=[0,1,2,3,4,5],qt=class{#e=new Map;of(e){let t=`${e.nearM} ${e.farM}`,r=this.#e.get(t)??Hs(e);return this.#e.set(t,r),r}};function Ku(n,e,t){let r=e,o=[n.size,...yt(n.size)].map(l=>{let d={at:r,pitch:Math.ceil(l[0]/Se)*Se,size:l};return r+=d.pitch*l[1],d});o[o.length-1].at=n.face;let{header:s,size:i,map:a}=n,c=t.add(`${s.range.nearM} ${s.range.farM}`,()=>t.depths.of(s.range)),u=s.isDistance?t.add([...i,...a.scale,...a.center].join(),()=>Xu(n)):F.NONE;return{planes:{levels:o,table:c,rayLengths:u},end:r}}function Xu({size:[n,e],map:t}){let r=new Float32Array(n*e);for(let o=0;o<e;o+=1)for(let s=0;s<n;s+=1)r[o*n+s]=St(t,s,o);return new Uint32Array(r.buffer)}var ir=class{constructor(e){this.depths=e}depths;parts=[];words=0;#e=new Map;add(e,t){let r=this.#e.get(e);if(r!==void 0)return r;let o=this.words,s=t();return this.parts.push(s),this.words+=s.length,this.#e.set(e,o),o}all(){let e=new Uint32Array(this.words),t=0;for(let r of this.parts)e.set(r,t),t+=r.length;return e}};function Vs(n,e,[t,r,o,s],i){return{below:n.at,below_pitch:n.pitch,below_width:n.size[0],below_height:n.size[1],left:t,top:r,width:o,output:e.at,pitch:e.pitch,limit:F.NONE,end:i+o*s}}var ar=class{steps=[];#e=[];#t=0;add(e,t,r,o){let s=r.at(-1)?.end??0;if(s>0){let i=$t([s,r.length],J(t,r));this.steps.push({kernel:e,pictures:o,at:this.#t,words:i.length,invocations:s}),this.#e.push(i),this.#t+=Math.ceil(i.length/Se)*Se}}all(){let e=new Uint32Array(this.#t);return this.steps.forEach(({at:t},r)=>e.set(this.#e[r],t)),e}},Kt=class{constructor(e,t,r,o){this.gpu=e;this.kernels=t;let s=new ir(o),i=ju;for(let c of r){let{planes:u,end:l}=Ku(c,i,s);this.#t.set(c.face,u),i=l}e.check("planes",i),e.check("tables",s.words);let a=new Uint32Array(i).fill(Gs);a[cr]=zs,this.planes=e.filled("planes",a),this.#e=e.filled("tables",s.all()),this.#r=e.buffer("jobs",0),this.hasGreatest=this.#t.size===$s.length&&$s.every(c=>this.#t.has(c))}gpu;kernels;planes;hasGreatest;#e;#t=new Map;#r;get bytes(){return this.planes.size+this.#e.size+this.#r.size}levels(e){return this.#t.get(e)?.levels??[]}write(e){let t=new ar,r=new Map;for(let{pictures:o,parts:s}of e){let i=0,a=s.map(c=>(i+=c.rect[2]*c.rect[3],r.set(c.face,Ut(r.get(c.face),c.rect)),{...this.#n(c),end:i}));t.add("texels","DepthJob",a,o)}return this.#o(r,t),t.steps.length>0&&this.#s(t),r}destroy(){[this.planes,this.#e,this.#r].forEach(e=>this.gpu.release(e))}#n({face:e,rect:[t,r,o],picture:s,corner:i}){let{levels:a,table:c,rayLengths:u}=this.#t.get(e),[{at:l,pitch:d,size:f}]=a,h={width:o,output:l+r*d+t,pitch:d};return s===void 0?{...h,picture:F.NONE,table:Gs,ray_length:F.NONE}:{...h,picture:s.picture,stride:s.stride,left:t-i[0],top:r-i[1],table:c,ray_length:u===F.NONE?u:u+r*f[0]+t,ray_length_pitch:f[0]}}#o(e,t){let r=Math.max(0,...[...e.keys()].map(o=>this.levels(o).length));for(let o=1;o<r;o+=1){let s=[];for(let[i,a]of e){let[c,u]=this.levels(i).slice(o-1,o+1);u!==void 0&&s.push(Vs(c,u,_t(a,o-1),s.at(-1)?.end??0))}t.add("squares","PyramidJob",s)}if(this.hasGreatest&&e.size>0){let o=qu.map(([s,i])=>({at:s,pitch:i,size:[i,1]}));for(let s=1;s<o.length;s+=1){let i=Vs(o[s-1],o[s],[0,0,o[s].size[0],1],0);t.add("squares","PyramidJob",[{...i,limit:zs}])}}}#s(e){let t=e.all();this.#r.size<4*t.length&&(this.gpu.release(this.#r),this.#r=this.gpu.buffer("jobs",t.length)),this.gpu.write(this.#r,0,t),this.gpu.submit(r=>{let o=r.beginComputePass({label:"planes"});for(let s of e.steps){let i=this.kernels[s.kernel],c={jobs:{buffer:this.#r,offset:4*s.at,size:4*s.words},tables:{buffer:this.#e},planes:{buffer:this.planes},...s.pictures&&{pictures:{buffer:s.pictures}}};o.setPipeline(i.pipeline),o.setBindGroup(0,this.gpu.bind(i,d=>c[d]));let u=Math.ceil(s.invocations/se(s.kernel).workgroup),l=Math.min(u,F.MAX_GROUPS);o.dispatchWorkgroups(l,Math.ceil(u/l))}o.end()})}};var js={steps:1024,refine:8,samples:1,holes:"behind",maxBounces:4,effects:!0},Yu=1e30,Qu=(2-2**-23)*2**127,Ju=4294967295,Zu=8,e3=8,Ws={light:0,srgb:1,linear:2},t3={blank:0,nearest:1,behind:2},r3=7,n3=0;function o3(n){return n.name==="light"?{coding:Ws.light,gain:1}:{coding:Ws[n.transfer],gain:2**-n.exposureEv}}function s3(n,e,t){let{texels:r,pyramid:o,layer:s}=t.origin(e,n.face);return{column:r[0],row:r[1],layer:s,has_material:+(n.material!==void 0),width:n.size[0],height:n.size[1],pyramid_column:o[0],pyramid_row:o[1],levels:yt(n.size).length,number:n.face,scale:n.map.scale,centre:n.map.center,has_alpha:+(n.alpha!==void 0)}}function i3({coding:n,views:e,nearest:t},{axes:[r,o,s],half:i},a,c){let u=a.distancesM.length,l=gs(a);return{forward:r,right:k(o,i[0]),down:k(s,i[1]),samples:c.samples,view_count:e.length,distance_count:u,refine:c.refine,tolerance:ps+a.uncertainty,holes:t3[c.holes],...o3(n),max_bounces:Math.min(c.maxBounces,e3),longest_segment:l.longest,first_segment:l.first,near_m:0,far_m:Qu,log_step:a.logStep,nearest_view:t,refinements:r3,background:n3}}function qs(n,e,[t,r],o,s){let i=ws(n,o.steps,o.refine),a=[],c=n.views.map(({view:l,streams:d,fromEye:f,turn:h,cameraWeight:m})=>{let p=new Array(Zu).fill(Ju);for(let E of d.faces)p[E.face]=a.length,a.push(s3(E,l,s));let[w,y,v]=h;return{from_eye:f,near_m:d.nearM,turn_x:w,camera_weight:m,turn_y:y,greatest_inverse_depth:Yu,turn_z:v,faces:p}}),u={width:t,height:r,pyramid_rows:s.arrays.pyramidRows};return{scene:J("Scene",[{...i3(n,e,i,o),...u}]),views:J("View",c),faces:J("Face",a),distancesM:new Uint32Array(i.distancesM.buffer)}}var Xt=["primary_rays","march_steps","refine_steps","secondary_rays","normal_evals","material_samples","hole_rays","background_rays"],Re=8,a3=-1,c3=2**28,u3=256,l3=50;function Ks([n,e]){return Math.ceil(n/Re)*Math.ceil(e/Re)*Xt.length}function d3(n){let e=r=>Math.min(u3,4**r),t=0;for(let r=0;r<n;r+=1)t+=3*e(r)+e(r+1);return t}function Xs(n,e,t,r){let o=t.steps+1+t.refine,s=t.samples**2*n*o*e*(1+r);return Math.max(Math.floor(c3/(s*Re)),1)*Re}var Ae=class{constructor(e){this.gpu=e;this.#e=e.buffer("pixels",0),this.#t=e.buffer("counts",0)}gpu;size=[0,0];#e;#t;get pixels(){return this.#e}get counts(){return this.#t}resize([e,t]){e===this.size[0]&&t===this.size[1]||(this.gpu.check("pixels",4*e*t),this.destroy(),this.#e=this.gpu.buffer("pixels",4*e*t),this.#t=this.gpu.buffer("counts",Ks([e,t])),this.size=[e,t])}async readPixels(){let e=await this.gpu.read(this.#e,0,4*this.size[0]*this.size[1]),t=new Float32Array(e.buffer);for(let r=3;r<t.length;r+=4)if(t[r]===a3)throw new O("The graphics device ended loops before they were done; take fewer steps.");return t}async readCounters(){let e=await this.gpu.read(this.#t,0,Ks(this.size)),t=new Array(Xt.length).fill(0);return e.forEach((r,o)=>t[o%Xt.length]+=r),Object.fromEntries(Xt.map((r,o)=>[r,t[o]]))}destroy(){this.gpu.release(this.#e),this.gpu.release(this.#t)}},Yt=class{constructor(e,t){this.gpu=e;this.texels=t}gpu;texels;#e=new Map;async render(e,t){let{active:r,camera:o,size:s,settings:i}=t,a=i.effects&&r.views.some(({view:w})=>this.texels.isSpecular(w)),c=await this.gpu.pipeline(a?"render-effects":"render-pyramid");e.resize(s),this.#t(qs(r,o,s,i,this.texels)),this.#r(r);let u=this.#n(c,e,t.colors),[l,d]=s,f=Xs(l,r.views.length,i,0),h=a?d3(i.maxBounces):0,m=Xs(l,r.views.length,i,h),p=m;for(let w=0;w<d;){let y=Math.min(p,d-w),v=performance.now();this.#o({pipeline:c,group:u,width:l,rows:[w,y]},t.timing?.()),w+=y,a&&w<d&&(await this.gpu.queue.onSubmittedWorkDone(),p=performance.now()-v<l3?Math.min(2*p,f):m)}}#t({scene:e,views:t,faces:r,distancesM:o}){for(let[s,i]of Object.entries({scene:e,views:t,faces:r,distances_m:o})){let a=this.#e.get(s);(a===void 0||a.size<i.byteLength)&&(a!==void 0&&this.gpu.release(a),a=this.gpu.buffer(s,i.length),this.#e.set(s,a)),this.gpu.write(a,0,i)}}#r({views:e}){let t=this.#e.get("views"),r=M("View","greatest_inverse_depth");this.gpu.submit(o=>{e.forEach(({view:s,streams:i},a)=>{let c=this.texels.planes(s);if(c.hasGreatest&&i.nearM>=bs){let u=4*(a*U("View")+r);o.copyBufferToBuffer(c.planes,4*cr,t,u,4)}})})}#n(e,t,r){let o=new Map([...this.#e,["pixels",t.pixels],["counts",t.counts]]);return this.gpu.bind(e,s=>{let i=o.get(s);if(i!==void 0)return{buffer:i};let a=s==="colors"&&r!==void 0?r:this.texels.arrays.view(s);if(a===void 0)throw new O(`No input of rendering is named ${s}.`);return a})}#o(e,t){let{pipeline:r,group:o,width:s,rows:i}=e,a=this.#e.get("scene");["first_row","rows"].forEach((c,u)=>{this.gpu.write(a,4*M("Scene",c),Uint32Array.of(i[u]))}),this.gpu.submit(c=>{let u=c.beginComputePass({label:"render",...t&&{timestampWrites:t}});u.setPipeline(r.pipeline),u.setBindGroup(0,o),u.dispatchWorkgroups(Math.ceil(s/Re),Math.ceil(i[1]/Re)),u.end()})}};var Qt={none:0,reinhard:1,filmic:2},Jt={mono:0,"side-by-side":1,anaglyph:2};var Ys=`// Shows pictures of linear light on a canvas.

struct PresentOptions {
  // Columns and rows of the pictures, then of the canvas.
  picture: vec2<f32>,
  canvas: vec2<f32>,
  gain: f32,
  // TONE_...
  tone: u32,
  // EYES_...
  eyes: u32,
  // Whether what no probe saw is marked, by its alpha.
  marks_holes: u32,
  // How much of the overlay is shown, 0 to 1.
  overlay: f32,
}

// Numbers of views/presentation.ts.
override TONE_REINHARD: u32;
override TONE_FILMIC: u32;
override EYES_SIDE_BY_SIDE: u32;
override EYES_ANAGLYPH: u32;
const HOLE_COLOR = vec3(1.0, 0.0, 1.0);

@group(0) @binding(0) var<uniform> options: PresentOptions;
@group(0) @binding(1) var<storage, read> left: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> right: array<vec4<f32>>;
// Of the size of the pictures.
@group(0) @binding(3) var<storage, read> overlay: array<vec4<f32>>;

@vertex
fn corner(@builtin(vertex_index) number: u32) -> @builtin(position) vec4<f32> {
  // A triangle that covers the canvas.
  return vec4(vec2(f32(number & 1u), f32(number >> 1u)) * 4.0 - 1.0, 0.0, 1.0);
}

// A pixel of an eye, over black or the mark of holes.
fn pixel(is_right: bool, at: vec2<i32>) -> vec3<f32> {
  let size = vec2<i32>(options.picture);
  let place = clamp(at, vec2(0), size - 1);
  let number = place.y * size.x + place.x;
  var rgba = left[number];
  if (is_right) {
    rgba = right[number];
  }
  let alpha = clamp(rgba.a, 0.0, 1.0);
  let behind = select(vec3(0.0), HOLE_COLOR, options.marks_holes != 0u);
  return mix(behind, rgba.rgb * options.gain, alpha);
}

// Light at a place of a picture, 0 to 1, between its four pixels.
fn light(is_right: bool, place: vec2<f32>) -> vec3<f32> {
  let at = place * options.picture - 0.5;
  let first = vec2<i32>(floor(at));
  let part = fract(at);
  let upper = mix(pixel(is_right, first), pixel(is_right, first + vec2(1, 0)), part.x);
  let lower = mix(pixel(is_right, first + vec2(0, 1)), pixel(is_right, first + vec2(1, 1)), part.x);
  return mix(upper, lower, part.y);
}

fn toned(color: vec3<f32>) -> vec3<f32> {
  let x = max(color, vec3(0.0));
  if (options.tone == TONE_REINHARD) {
    return x / (1.0 + x);
  }
  if (options.tone == TONE_FILMIC) {
    // A rational curve with a toe and a shoulder.
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
  }
  return x;
}

// The curve of IEC 61966-2-1.
fn coded(color: vec3<f32>) -> vec3<f32> {
  let x = clamp(color, vec3(0.0), vec3(1.0));
  return select(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3(0.0031308));
}

@fragment
fn show(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
  let place = position.xy / options.canvas;
  var color: vec3<f32>;
  var mark = vec2<u32>(place * options.picture);
  if (options.eyes == EYES_SIDE_BY_SIDE) {
    let is_right = place.x >= 0.5;
    let part = vec2(2.0 * place.x - select(0.0, 1.0, is_right), place.y);
    color = light(is_right, part);
    mark = vec2<u32>(part * options.picture);
  } else {
    color = light(false, place);
    if (options.eyes == EYES_ANAGLYPH) {
      color = vec3(color.r, light(true, place).gb);
    }
  }
  let marked = overlay[min(mark.y * u32(options.picture.x) + mark.x, arrayLength(&overlay) - 1u)].rgb;
  return vec4(mix(coded(toned(color)), coded(marked), options.overlay), 1.0);
}
`;var h3={TONE_REINHARD:Qt.reinhard,TONE_FILMIC:Qt.filmic,EYES_SIDE_BY_SIDE:Jt["side-by-side"],EYES_ANAGLYPH:Jt.anaglyph},Qs=10,Zt=class n{constructor(e,t,r){this.gpu=e;this.canvas=t;this.#e=r.context,this.#t=r.pipeline;let o=GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST;this.#r=e.device.createBuffer({label:"options",size:4*Qs,usage:o})}gpu;canvas;#e;#t;#r;static async create(e,t){let r=t.getContext("webgpu");if(r===null)throw new O("The canvas cannot be drawn to by the graphics device.");let o=navigator.gpu.getPreferredCanvasFormat();r.configure({device:e.device,format:o,alphaMode:"opaque"});let s=e.device.createShaderModule({label:"present",code:Ys}),i=await e.device.createRenderPipelineAsync({label:"present",layout:"auto",vertex:{module:s,entryPoint:"corner"},fragment:{module:s,entryPoint:"show",constants:h3,targets:[{format:o}]}});return new n(e,t,{context:r,pipeline:i})}show([e,t,r],o){let s=new Uint32Array(Qs),i=new Float32Array(s.buffer);i.set([...e.size,this.canvas.width,this.canvas.height,2**o.exposureEv]),s.set([Qt[o.toneMap],Jt[o.stereo],Number(o.marksHoles)],5),i[8]=o.overlay,this.gpu.write(this.#r,0,s);let a=[this.#r,e.pixels,t.pixels,r.pixels],c=this.gpu.device.createBindGroup({layout:this.#t.getBindGroupLayout(0),entries:a.map((u,l)=>({binding:l,resource:{buffer:u}}))});this.gpu.submit(u=>{let l=this.#e.getCurrentTexture().createView(),d=u.beginRenderPass({colorAttachments:[{view:l,loadOp:"clear",storeOp:"store"}]});d.setPipeline(this.#t),d.setBindGroup(0,c),d.draw(3),d.end()})}};var ur=class extends ve{constructor(t,r,o){super(t);this.tile=r;this.pictures=o;this.copied=[0,0,...t.size]}tile;pictures;staleCells=new Set;specular=new Set;copied;get depthPictures(){return this.pictures.get(this.streams.depth.index)}takeDepths(){let{decoder:t,position:r}=this.depthPictures;return this.takeParts().map(({rect:o,tile:s,isKnown:i})=>{let[a,c]=S(this.streams.depth,s),u=i?t.unit(r,s):void 0;return{face:this.streams.face,rect:o,picture:u,corner:[a,c]}})}},e1=class n{constructor(e,t,r,o){this.gpu=e;this.kernels=t;this.catalogue=r;this.arrays=new vt(e,r,o)}gpu;kernels;catalogue;arrays;#e=new qt;#t=new Map;#r=new xe;static async create(e,t,r){let[o,s]=await Promise.all([e.pipeline("texels"),e.pipeline("squares")]);return new n(e,{texels:o,squares:s},t,r)}load(e,t){let{faces:r}=this.catalogue.views[e],o=new Kt(this.gpu,this.kernels,r,this.#e),s=r.map(()=>this.arrays.take()),i=r.flatMap((a,c)=>{let u=s[c];return u===void 0?[]:[new ur(a,u,t)]});if(i.length<r.length)throw i.forEach(({tile:a})=>this.arrays.free(a)),o.destroy(),new O("The textures have no room for another probe.");this.#t.set(e,o),this.#r.load(e,i)}unload(e){this.planes(e).destroy(),this.#t.delete(e),this.#r.unload(e).forEach(({tile:t})=>this.arrays.free(t))}get bytes(){return[...this.#t.values()].reduce((e,{bytes:t})=>e+t,0)}isKnown(e,t){return this.#r.isKnown(e,t)}written(e,t){let{face:r}=this.#r.ofStream(e);this.#r.setKnown(e,t,!0),e!==r.streams.depth.index&&r.pictures.has(e)&&r.staleCells.add(t)}forget(e,t){this.#r.setKnown(e,t,!1)}uploadColor(e,t,r){this.arrays.upload("colors",this.#r.ofStream(e).face.tile,t,r)}uploadMaterial(e,t,r){let{face:o,units:s}=this.#r.ofStream(e),i=new Uint8Array(r.length/3*4),a=!1;for(let c=0,u=0;c<r.length;c+=3,u+=4)i.set([r[c],r[c+1],r[c+2]],u),a||=r[c]>0||r[c+1]>0;o.specular.delete(t),a&&o.specular.add(t),this.arrays.upload("materials",o.tile,S(s.stream,t),i),this.written(e,t)}isSpecular(e){return this.#t.has(e)&&this.#r.ofView(e).some(({specular:t})=>t.size>0)}update(){let e=this.gpu.device.createCommandEncoder({label:"texels"}),t=!1;for(let[r,o]of this.#r.views()){let s=this.planes(r),i=new Map;for(let c of o){let{pictures:u}=c.depthPictures.decoder,l=i.get(u)??{pictures:u,parts:[]};l.parts.push(...c.takeDepths()),i.set(u,l)}let a=s.write([...i.values()]);for(let c of o){let u=this.#n(e,{planes:s,face:c},a.get(c.streams.face));t||=u}}t&&this.gpu.queue.submit([e.finish()])}origin(e,t){return this.arrays.origin(this.tile(e,t))}tile(e,t){let r=this.#r.ofView(e).find(({streams:o})=>o.face===t);if(r===void 0)throw new Error(`View ${e} has no face ${t}`);return r.tile}planes(e){let t=this.#t.get(e);if(t===void 0)throw new Error(`View ${e} is not loaded`);return t}#n(e,{planes:t,face:r},o){let s=o===void 0?r.copied:Ut(r.copied,o);r.copied=void 0,s!==void 0&&this.arrays.copyDepth(e,r.tile,s,{planes:t,face:r.streams.face});let i=s!==void 0||r.staleCells.size>0,{color:a}=r.streams;for(let c of r.staleCells){let{decoder:u,position:l}=r.pictures.get(a.index),{picture:d,stride:f}=u.unit(l,c),h=S(a,c);this.arrays.copyColor(e,r.tile,h,{buffer:u.pictures,at:d,pitch:f})}return r.staleCells.clear(),i}};var t1=class{constructor(e,t,r,o){this.decoder=e;this.decoding=t;this.keptWords=r;this.timing=o}decoder;decoding;keptWords;timing;#e=[];#t=new Set;#r=new Set;#n=new Set;#o=new Set;#s=!1;units(e){return new lr(this,e)}shows(e,t){return this.decoder.shows(this.#i(e,t))}#i(e,{unit:t,frame:r,chunk:o,next:s}){let{firstFrame:i}=this.decoding.container.chunks[o];return{stream:e,unit:t,frame:r,key:o+1,firstFrame:i,nextKey:s+1}}ask(e,t,r){let o=this.prepare(e,t,r);return o==="ready"&&this.#e.push(this.#i(e,t)),o}prepare(e,t,r){let{chunk:o,next:s}=t,i=this.#i(e,t);if(this.decoder.shows(i))return"shown";let a=[this.#a(o,r)];return a[0]==="shown"&&s>=0&&this.decoder.needsNext(i)&&a.push(this.#a(s,r)),a.every(c=>c==="shown")?"ready":["broken","missing","working"].find(c=>a.includes(c))??"working"}decode(){let[e,t]=[this.#e,this.#r];this.#e=[],this.#t=t,this.#r=new Set;let r=this.decoder.decode(e,e.length>0?this.timing():void 0);return r.refused.forEach(({key:o})=>this.#o.add(o)),this.decoder.drop(t,this.keptWords),{changed:r.written.map(({wanted:o})=>o),pixels:r.pixels,behind:r.behind.length}}close(){this.#s=!0,this.decoder.destroy()}#a(e,t){let r=e+1;if(this.#r.add(r),this.decoder.has(r))return"shown";if(this.#o.has(r))return"broken";if(this.#n.has(r))return"working";let o=ee(this.decoding,e,t);return o===void 0?"missing":(this.#n.add(r),this.decoding.pool.prepare(o,()=>!0).then(s=>{this.#n.delete(r),!this.#s&&(s!==void 0&&!this.decoder.add(r,s)&&(this.decoder.drop(this.#t,0),this.decoder.add(r,s)||(this.#o.add(r),this.decoding.onBroken("The graphics device has no room for the chunks of a frame."))),this.decoding.onReady())},s=>{this.#n.delete(r),this.#o.add(r),this.decoding.onBroken(s.message),this.decoding.onReady()}),"working")}},lr=class{constructor(e,t){this.family=e;this.position=t}family;position;get stream(){return this.family.decoder.streams[this.position]}hasPicture(e){return this.family.decoder.showsAny(this.position,e)}shows(e){return this.family.shows(this.position,e)}ask(e,t){return this.family.ask(this.position,e,t)}prepare(e,t){return this.family.prepare(this.position,e,t)}};var r1=class{#e;#t;#r;#n=[];constructor(e){if(this.#e=e,e.hasTimestamps){this.#t=e.device.createQuerySet({type:"timestamp",count:2*256});let t=GPUBufferUsage.QUERY_RESOLVE|GPUBufferUsage.COPY_SRC;this.#r=e.device.createBuffer({label:"timestamps",size:4096,usage:t})}}pass(e){if(this.#t===void 0||this.#n.length===256)return;let t=2*this.#n.length;return this.#n.push(e),{querySet:this.#t,beginningOfPassWriteIndex:t,endOfPassWriteIndex:t+1}}async read(){let e=new Map,[t,r,o]=[this.#t,this.#r,this.#n];if(this.#n=[],t===void 0||r===void 0||o.length===0)return e;this.#e.submit(a=>a.resolveQuerySet(t,0,2*o.length,r,0));let s=await this.#e.read(r,0,4*o.length),i=new BigUint64Array(s.buffer);return o.forEach((a,c)=>{let[u,l]=[i[2*c],i[2*c+1]],d=u>0n&&l>u?Number(l-u)/1e6:0;e.set(a,(e.get(a)??0)+d)}),e}};var m3=256<<20;function p3({color:{header:n},alpha:e}){return n.kind==="color"&&!n.isHalf&&n.coding.name==="cells"&&e===void 0}var n1=class n{constructor(e,t,r,o){this.gpu=e;this.scene=t;this.texels=r;this.presenter=o;this.#e=new Yt(e,r),this.#t=new r1(e),this.#r=[new Ae(e),new Ae(e),new Ae(e)],e.onError=s=>this.onFailed(`The graphics device failed: ${s}`),e.lost.then(s=>this.onFailed(`The graphics device was lost: ${s}`))}gpu;scene;texels;presenter;name="gpu";mostPixels=1/0;onFailed=()=>{};#e;#t;#r;#n;static async create(e,t){e.pipeline("render-pyramid");let[r,o]=await Promise.all([e1.create(e,t.catalogue,t.mostImages),Zt.create(e,t.canvas)]);return new n(e,t,r,o)}get hasEffects(){return!this.gpu.isSoftware}async load(e,t){let{decoding:r,mostViews:o}=this.scene,s=new Map;for(let d of t.flatMap(f=>[f.depth,...p3(f)?[f.color]:[]])){let{kernel:f}=ke(d.header);s.set(f,[...s.get(f)??[],d])}let i=Math.floor(m3/4/(2*o)),a=[...s.values()].map(d=>jt.create(this.gpu,d,Se)),c=()=>this.#t.pass("decode"),u=(await Promise.all(a)).map(d=>new t1(d,r,i,c)),l=new Map;for(let{decoder:d}of u)d.streams.forEach(({index:f},h)=>l.set(f,{decoder:d,position:h}));return this.texels.load(e,l),this.#n?.painter.forget(e),u}async draw(e,t){let{view:r,cameras:o,views:s}=e,i=performance.now(),{container:a,catalogue:c,canvas:u}=this.scene,l=$e(e),d=r.overlays.has("holes"),f={...js,steps:r.steps,holes:d?"nearest":"behind",effects:this.hasEffects},[h,m,p]=this.#r,w=C=>{let V=k1=>a.probeAt(k1,r.frame);return{active:Ot(c,s,C.eye,V),camera:C,size:l,settings:f}},y=()=>this.#t.pass("march");for(let[C,V]of o.entries())await this.#e.render(this.#r[C],{...w(V),timing:y});let v=Ft(r);if(v.length>0){this.#n??=this.#o(),this.#n.painter.paint(v,e);let C=w(o[0]),V=C.active.coding.name==="light"?C.active.coding:Pt;await this.#e.render(p,{...C,active:{...C.active,coding:V},colors:this.#n.view})}[u.width,u.height]=r.size;let E=v.length>0;this.presenter.show([h,o.length>1?m:h,E?p:h],{exposureEv:r.exposureEv,toneMap:r.toneMap,stereo:r.stereo,marksHoles:d,overlay:E?Nt:0}),t();let $=await h.readCounters(),x=performance.now()-i,Y=await this.#t.read();return{counters:$,decodeMs:Y.get("decode")??0,marchMs:Y.get("march")??x}}async decodeMs(){return(await this.#t.read()).get("decode")??0}async pixels(){let[e]=this.#r;return{size:[...e.size],rgba:await e.readPixels()}}close(){this.gpu.destroy()}#o(){let{container:e,catalogue:t}=this.scene,{arrays:r}=this.texels,o=r.colorTexture("overlay");return{painter:new ye(e,t,({view:i,face:a},c,u)=>{let l=r.colorFormat==="rgba8unorm"?u:b3(u);r.upload(o,this.texels.tile(i,a),c,l)}),view:o.createView({dimension:"2d-array"})}}};function b3(n){let e=Array.from({length:256},(t,r)=>At(He(r,"srgb")));return Uint16Array.from(n,t=>e[t])}var w3={cacheBytes:256<<20,parallel:6,requestBytes:2<<20,retryDelayMs:200,maxDelayMs:1e4},g3=4,Js=1e3;function y3({offset:n,storedBytes:e}){return{key:ne({offset:n,storedBytes:e}),offset:n,bytes:e}}function ne({offset:n,storedBytes:e}){return`${n} ${e}`}var o1=class{constructor(e,t=w3){this.source=e;this.settings=t}source;settings;kept=new Map;wanted=new Map;wantedAt=new Map;inUse=new Set;pending=new Set;requests=new Set;everFetched=new Set;arrivals=[];timer;failures=0;closed=!1;counts={bytesFetched:0,requests:0,chunksFetched:0,chunksRefetched:0};cachedBytes=0;onChunk=()=>{};onProblem=()=>{};want(e,t=[]){let r=e.filter(({storedBytes:o})=>o>0).map(y3);this.wanted=new Map(r.map(o=>[o.key,o])),this.wantedAt=new Map(r.map(o=>[o.offset,o])),this.inUse=new Set(t.map(ne));for(let o of[...this.inUse,...this.wanted.keys()])this.touch(o);this.trim(),this.pump()}get(e){return e.storedBytes===0?new Uint8Array(0):this.kept.get(ne(e))}get stats(){let e=performance.now();for(;this.arrivals.length>0&&this.arrivals[0].at<e-Js;)this.arrivals.shift();let t=this.arrivals.reduce((r,o)=>r+o.bytes,0);return{...this.counts,cacheBytes:this.cachedBytes,fetchRate:t*1e3/Js}}close(){this.closed=!0,clearTimeout(this.timer),this.requests.forEach(e=>e.abort.abort())}touch(e){let t=this.kept.get(e);t!==void 0&&(this.kept.delete(e),this.kept.set(e,t))}trim(){for(let[e,t]of this.kept){if(this.cachedBytes<=this.settings.cacheBytes)return;!this.wanted.has(e)&&!this.inUse.has(e)&&(this.kept.delete(e),this.cachedBytes-=t.length)}}isMissing(e){return e!==void 0&&!this.kept.has(e.key)&&!this.pending.has(e.key)}pump(){if(!(this.closed||this.timer!==void 0))for(let e of this.wanted.values()){if(this.requests.size>=this.settings.parallel)return;this.isMissing(e)&&this.fetch(this.runFrom(e))}}runFrom(e){let t=[e],r=e.offset+e.bytes;for(;;){let o=this.wantedAt.get(r);if(!this.isMissing(o)||r+o.bytes-e.offset>this.settings.requestBytes)return t;t.push(o),r+=o.bytes}}async fetch(e){let t={ranges:e,abort:new AbortController},r=e.reduce((s,{bytes:i})=>s+i,0);this.requests.add(t),e.forEach(({key:s})=>this.pending.add(s)),this.counts.requests+=1;let o;try{let s=await this.source.read(e[0].offset,r,t.abort.signal);this.closed||(this.failures=0,this.arrive(e,s))}catch(s){o=s}this.requests.delete(t),e.forEach(({key:s})=>this.pending.delete(s)),!this.closed&&(o!==void 0?this.fail(o):e.filter(({key:s})=>this.wanted.has(s)).forEach(({key:s})=>this.onChunk(s)),this.pump())}arrive(e,t){let r=0;for(let{key:o,bytes:s}of e)this.kept.set(o,t.slice(r,r+s)),this.cachedBytes+=s,this.counts.chunksFetched+=1,this.counts.chunksRefetched+=Number(this.everFetched.has(o)),this.everFetched.add(o),r+=s;this.counts.bytesFetched+=t.length,this.arrivals.push({at:performance.now(),bytes:t.length}),this.trim()}fail(e){if(e instanceof Te){this.closed=!0,this.requests.forEach(t=>t.abort.abort()),this.onProblem({fatal:!0,message:e.message});return}if(!(e instanceof B)){this.closed=!0,this.onProblem({fatal:!0,message:e instanceof Error?e.message:String(e)});return}if(this.failures+=1,this.failures>=g3&&this.onProblem({fatal:!1,passes:!0,message:`${e.message}; trying again`}),this.timer===void 0){let t=this.settings.retryDelayMs*2**Math.min(this.failures-1,16);this.timer=setTimeout(()=>{this.timer=void 0,this.pump()},Math.min(t,this.settings.maxDelayMs))}}};function _3({streams:n}){let e=n.reduce((r,{firstFrame:o})=>Math.min(r,o),1/0),t=n.reduce((r,{firstFrame:o,frameCount:s})=>Math.max(r,o+s-1),-1/0);return n.length===0?[0,0]:[e,t]}function v3([n,e,t,r]){let o=[-2*(n*t+r*e),2*(r*n-e*t),2*(n*n+e*e)-1],s=Math.asin(Math.max(-1,Math.min(1,o[1])));return{yaw:Math.atan2(-o[0],-o[2]),pitch:s}}function x3(n){let e=[0,1,2],t=s=>n.map(i=>i[s]),r=e.map(s=>t(s).reduce((i,a)=>Math.min(i,a),1/0)),o=e.map(s=>t(s).reduce((i,a)=>Math.max(i,a),-1/0));return{least:r,greatest:o}}function Zs(n,e){return n.reduce((t,r,o)=>t+(r-e[o])**2,0)}function ei(n,e){let[t,r]=_3(n),s=(f=>e.map(h=>n.probeAt(h,f)))(t),i=n.footage.poses,a=e.flatMap(f=>i.get(n.probes[f].name)??[]),c=x3([...s,...a].map(({position:f})=>f)),u=c.least.map((f,h)=>(f+c.greatest[h])/2),l=s.reduce((f,h)=>Zs(h.position,u)<Zs(f.position,u)?h:f),d={eye:[...l.position],...v3(l.orientation)};return{name:n.name,fileBytes:n.source.byteCount,framesPerSecond:n.fps,firstFrame:t,frameCount:r-t+1,headBox:c,probes:s.map(({name:f,position:h})=>({name:f,position:h})),start:d,streams:k3(n)}}function k3({streams:n,chunks:e}){let t=new Float64Array(n.length),r=new Set;for(let s of e){let i=ne(s);t[s.stream]+=r.has(i)?0:s.storedBytes,r.add(i)}let o=new Map;for(let{index:s,kind:i,codec:a}of n){let c=`${i} ${a}`,u=o.get(c)??{kind:i,codec:a,count:0,bytes:0};o.set(c,{...u,count:u.count+1,bytes:u.bytes+t[s]})}return[...o.values()]}var s1=class{#e;#t;next(e,t,r){let o=this.#e,s=t&&o!==void 0&&!o.isWhole&&e>o.frame&&!this.#r(o,r);return(o===void 0||o.frame!==e&&!s)&&(this.#e={frame:e,sinceMs:r,isWhole:!1}),this.#e.frame}get shown(){return this.#t}show(e,t,r){let o=this.#e;return o.isWhole=e,(e||!t||this.#t===void 0||this.#r(o,r))&&(this.#t=o.frame),this.#t}#r({sinceMs:e},t){return t-e>=500}};var We=class{constructor(e,t){this.stream=e;this.decoding=t}stream;decoding;#e=new Set;#t=new Map;#r=new Set;#n=new Set;hasPicture(e){return this.#t.get(e)?.shown!==void 0}shows({unit:e,chunk:t,frame:r}){let o=this.#t.get(e)?.shown;return o?.chunk===t&&o.frame===r}frame(e){return this.#t.get(e)?.shown?.frame}pixels(e){return this.#t.get(e)?.shown?.pixels}takeChanged(){let e=[...this.#e];return this.#e=new Set,e}ask(e,t){let{ready:r}=this.#o(e.unit);[...r.keys()].filter(i=>!Mt(this.decoding.frames,i)).forEach(i=>r.delete(i));let s=this.prepare(e,t);return s==="ready"&&(this.#s(e.unit,r.get(e.frame)),r.delete(e.frame)),s}prepare(e,t){return this.shows(e)?"shown":this.#o(e.unit).ready.get(e.frame)?.chunk===e.chunk?"ready":this.#i(e,t)}#o(e){let t=this.#t.get(e)??{shown:void 0,ready:new Map,working:new Set};return this.#t.set(e,t),t}#s(e,t){this.#o(e).shown=t,this.#e.add(e)}#i(e,t){if(this.#r.has(e.chunk))return"broken";let r=this.#o(e.unit),o=ee(this.decoding,e.chunk,t),s=e.next>=0&&this.#n.has(e.chunk),i=s?ee(this.decoding,e.next,t):void 0;if(o===void 0||s&&i===void 0)return"missing";if(!r.working.has(e.frame)){r.working.add(e.frame);let a=e.frame-o.chunk.firstFrame;this.decoding.pool.decode(o,a,()=>Mt(this.decoding.frames,e.frame),i).then(u=>this.#a(e,u),u=>this.#l(e,u))}return"working"}#a(e,t){let r=this.#o(e.unit);if(r.working.delete(e.frame),t==="next")this.#n.add(e.chunk);else if(t!==void 0){let o={pixels:t,chunk:e.chunk,frame:e.frame},{frames:s}=this.decoding;e.frame===s.shown||r.shown===void 0?this.#s(e.unit,o):Mt(s,e.frame)?r.ready.set(e.frame,o):(r.shown.frame>s.shown||r.shown.frame<e.frame&&e.frame<s.shown)&&this.#s(e.unit,o)}this.decoding.onReady()}#l(e,t){this.#o(e.unit).working.delete(e.frame),this.#r.add(e.chunk),this.decoding.onBroken(t.message),this.decoding.onReady()}};var i1=class n{constructor(e,t,r,o){this.context=e;this.view=t;this.streams=r;this.#e=o.families,this.#t=o.sources;let{container:s}=e.decoding;this.#r=s.footage.poses.has(s.probes[r.probe].name)}context;view;streams;#e;#t;#r;#n=[];lastUsed=0;static async load(e,t,r){let{renderer:o,decoding:s}=e,i=new Map,a=await o.load(t,r.faces,(u,l)=>i.get(u)?.pixels(l)),c=new Map;for(let u of a)u.decoder.streams.forEach((l,d)=>c.set(l,u.units(d)));for(let u of r.faces.flatMap(we).filter(l=>!c.has(l))){let l=new We(u,s);i.set(u.index,l),c.set(u,l)}return new n(e,t,r,{families:a,sources:c})}ask(e,{sees:t,fetch:r,counts:o}){this.#n=[],this.#o(e,t,(s,i,a,c)=>{c!==void 0&&(o[i.ask(c,r)]+=1),this.#r&&this.#n.push({stream:s,source:i,unit:a,wanted:c})})}prepare(e,{sees:t,fetch:r,counts:o}){this.#o(e,t,(s,i,a,c)=>{c!==void 0&&(o[i.prepare(c,r)]+=1)})}#o(e,t,r){let{container:o}=this.context.decoding;for(let[s,i]of this.#t)for(let a=0;a<o.unitCount(s.index);a+=1)r(s,i,a,t(s,a)?Tt(o,s.index,a,e):void 0)}update(){let{texels:e}=this.context.renderer,[t,r,o]=[0,0,0];for(let s of this.#e){let i=s.decode();r+=i.pixels,o+=i.behind,t+=i.changed.length;for(let{stream:a,unit:c}of i.changed)e.written(s.decoder.streams[a].index,c)}for(let s of this.streams.faces){let i=this.#a(s);t+=i.length,r+=i.reduce((a,[c,u])=>{let[,,l,d]=this.context.decoding.container.unitRect(c.index,u);return a+l*d},0)}return this.#s(),{units:t,pixels:r,behind:o}}#s(){let{texels:e}=this.context.renderer;for(let{stream:t,source:r,unit:o,wanted:s}of this.#n){let i=s!==void 0&&r.shows(s);i&&!e.isKnown(t.index,o)?e.written(t.index,o):!i&&r.hasPicture(o)&&e.forget(t.index,o)}this.#n=[]}unload(){this.context.renderer.texels.unload(this.view),this.#e.forEach(e=>e.close())}#i(e){let t=e&&this.#t.get(e);return t instanceof We?t:void 0}#a({depth:e,color:t,alpha:r,material:o}){let{texels:s}=this.context.renderer,[i,a,c]=[t,r,o].map(m=>this.#i(m)),l=(this.#i(e)?.takeChanged()??[]).map(m=>[e,m]);for(let m of c?.takeChanged()??[])s.uploadMaterial(c.stream.index,m,c.pixels(m)),l.push([c.stream,m]);let d=i?.takeChanged()??[],f=a?.takeChanged()??[],h=f.flatMap(m=>[..._e(t,this.#f(a,m).rect)]);for(let m of new Set([...d,...h.map(([p])=>p)]))i!==void 0&&i.hasPicture(m)&&this.#l(i,m,a)&&l.push([t,m]);return l.push(...f.map(m=>[a.stream,m])),l.forEach(([m,p])=>s.written(m.index,p)),l}#l(e,t,r){let{renderer:o,colors:s}=this.context,{texels:i}=o,a=this.#f(e,t);if(r===void 0)return i.uploadColor(e.stream.index,a.rect,s.of(a,a.rect)),!0;let c=!0;for(let[u,l]of _e(r.stream,a.rect))r.frame(u)===e.frame(t)?i.uploadColor(e.stream.index,l,s.of(a,l,this.#f(r,u))):c=!1;return c}#f(e,t){return{pixels:e.pixels(t),rect:this.context.decoding.container.unitRect(e.stream.index,t)}}};var a1=class{constructor(e,t,r){this.outline=r;this.members=Array.from({length:e},()=>this.member(t()))}outline;members;nextId=0;onFailed=()=>{};get pending(){return this.members.reduce((e,{queue:t,sent:r})=>e+t.length+r.size,0)}async prepare(e,t){let r=await this.run({...e,id:this.nextId++},t);return r&&"prepared"in r?r.prepared:void 0}async decode(e,t,r,o){let s={...e,id:this.nextId++,frame:t,...o&&{next:o}},i=await this.run(s,r);return i&&"needsNext"in i?"next":i&&"pixels"in i?i.pixels:void 0}async codings(e,t,r){let o=await this.run({...e,id:this.nextId++,frame:t,asksCodings:!0},r);return o&&"pixels"in o?o.pixels:void 0}close(){this.members.forEach(({worker:e})=>e.terminate()),this.members.forEach(e=>e.queue=[])}member(e){let t={worker:e,knows:new Set,queue:[],sent:new Map,failure:void 0};return e.onmessage=({data:r})=>this.finish(t,r),e.onerror=({message:r})=>this.fail(t,`A worker of the player failed: ${r??"it did not load"}`),e.onmessageerror=()=>this.fail(t,"A worker of the player failed: its answer cannot be read"),t}async run(e,t){let{stream:r,unit:o}=e.chunk,s=this.members[(r+o)%this.members.length],i=await new Promise(a=>{s.queue.push({job:e,isWanted:t,resolve:a}),this.pump(s)});if(i&&"error"in i)throw new Error(i.error);return i}pump(e){for(;e.sent.size<8&&e.queue.length>0;){let t=e.queue.shift(),{job:r}=t;if(e.failure!==void 0){t.resolve({id:r.id,error:e.failure});continue}if(!t.isWanted()){t.resolve(void 0);continue}e.sent.set(r.id,t);let{stream:o}=r.chunk,s=e.knows.has(o)?void 0:this.outline(o);e.knows.add(o),e.worker.postMessage({...r,...s&&{outline:s}})}}fail(e,t){e.failure===void 0&&(e.failure=t,this.onFailed(t)),[...e.sent.keys()].forEach(r=>this.finish(e,{id:r,error:t})),this.pump(e)}finish(e,t){let r=e.sent.get(t.id);e.sent.delete(t.id),r?.resolve(t),this.pump(e)}};var E3=5,S3=200;async function je(n){for(let e=1;;e+=1)try{return await n()}catch(t){if(!(t instanceof B)||e===E3)throw t;await new Promise(r=>setTimeout(r,S3*2**(e-1)))}}var ti=1<<30,R3=4,A3=512<<20,M3=4,T3=3,C3=3,O3=2,P3=.5,N3=6,F3=300,U3=1e3,L3=1500;async function ri(n,e,t){let[r,o]=await Promise.allSettled([D3(t),je(()=>gt.open(n))]);if(r.status==="rejected")throw r.reason;let s=r.value,i,a;try{if(o.status==="rejected")throw o.reason;let c=o.value,u=cs(c),l=s===void 0?I3(u):u,d=Math.max(...l.views.map(({faces:m})=>m.length)),f=B3(l,d,s===void 0);i=H3(c);let h={container:c,catalogue:l,canvas:e,decoding:i,mostViews:f,mostImages:f*d};return a=s===void 0?new Bt(h):await n1.create(s,h),new dr({renderer:a,decoding:i,catalogue:l,mostViews:f})}catch(c){throw i?.store.close(),i?.pool.close(),a?.close(),s?.destroy(),c}}function I3({views:n,coding:e}){let t=({faces:r,...o})=>({...o,faces:r.map(s=>({...s,material:void 0}))});return{views:n.map(t),coding:e}}function B3(n,e,t){let{views:r}=n,o=e*T3*jo(n);if(t&&o>ti)throw new g("The images of a probe are larger than the processor draws; a graphics device may.");let s=Math.max(1,Math.floor(ti/o));return Math.min(r.length,s,t?M3:1/0)}async function D3(n){if(n==="cpu")return;let e=await M1();return n==="auto"&&T1(e)?void 0:Je.open(e)}function H3(n){let e=Math.max(1,Math.min(R3,(navigator.hardwareConcurrency||2)-1)),t={keptBytes:A3/e},r=()=>{let i=new Worker(new URL("./worker.js",import.meta.url),{type:"module"});return i.postMessage(t),i},o=new a1(e,r,i=>{let{kind:a,codec:c,face:u,width:l,height:d,unitWidth:f,unitHeight:h,headerBytes:m}=n.streams[i];return{stream:{kind:a,codec:c,face:u,width:l,height:d,unitWidth:f,unitHeight:h},headerBytes:m}}),s=new o1(n.source);return{container:n,frames:{shown:0,next:[0,0]},store:s,pool:o,onReady:()=>{},onBroken:()=>{}}}var dr=class{film;onProblem=()=>{};onShown=()=>{};#e;#t;#r;#n;#o;#s;#i;#a=new Map;#l;#f=new Map;#c;#u=0;#d=new s1;#h;#m;#x=performance.now();#b=!1;#p=0;#k={cells_decoded:0,pixels_decoded:0};#E;#w=()=>{};#g=!1;constructor({renderer:e,decoding:t,catalogue:r,mostViews:o}){let{container:s,store:i,pool:a}=t;this.#e=e,this.#t=s,this.#r=r,this.#n=t,this.#l=o,this.film=ei(s,r.views.map(({probe:u})=>u)),this.#m=this.film.firstFrame,i.onChunk=u=>{this.#f.set(u,performance.now()),this.#w()},i.onProblem=u=>this.#y(u),this.#c=new Ct(t),a.onFailed=u=>this.#y({fatal:!0,message:u}),e.onFailed=u=>this.#y({fatal:!0,message:u}),t.onReady=()=>this.#w(),t.onBroken=u=>this.#y({fatal:!1,message:u});let c=r.views.some(({faces:u})=>u.some(({alpha:l})=>l!==void 0));this.#o={renderer:e,decoding:t,colors:new Rt(r.coding,c)},this.#s=new Ge(s),this.#i=new Ge(s)}get renderer(){return this.#e.name}get mostPixels(){return this.#e.mostPixels}async draw(e){let t=await this.#A(e),{counts:r,active:o}=t,s=r.missing+r.working;this.#b||=s===0||performance.now()-this.#x>L3;let i=this.#b?await this.#R(t):void 0;this.#m=s===0?t.view.frame:this.#m;let a=this.#n.store.stats;return{...a,counters:{...i?.counters,...this.#k,cells_unchanged:r.shown,bytes_read:a.bytesFetched,active_probes:o.length},decodeMs:i?.decodeMs??await this.#e.decodeMs(),marchMs:i?.marchMs??0,unitsMissing:s,unitsBroken:r.broken,overlayMissing:this.#u,shownFrame:this.#m}}async settle(e){for(;;){let t=new Promise(o=>this.#w=o),{counts:r}=await this.#A(e);if(r.missing+r.working===0||this.#g)return;await Promise.all([t,this.#e.decodeMs()])}}fetched(){let{firstFrame:e,frameCount:t}=this.film,r=this.#E;if(r===void 0)return[];let o=this.#T(r.pose.eye,r.frame),s=(l,d)=>this.#s.sees(l,d),i=this.#_(o,s,[0,1/0]).filter(l=>this.#n.store.get(l)===void 0).map(l=>[l.firstFrame,l.firstFrame+l.frameCount-1]).sort((l,d)=>l[0]-d[0]),a=[],c=e;for(let[l,d]of i)l>c&&a.push([c,l-1]),c=Math.max(c,d+1);let u=e+t-1;return c<=u?[...a,[c,u]]:a}pixels(){return this.#e.pixels()}close(){this.#g=!0,this.#w(),this.#n.store.close(),this.#n.pool.close(),this.#e.close()}#y(e){this.#g||this.onProblem(e)}async#A(e){let{playing:t}=e,r=this.#d.next(this.#M(e.frame),t,performance.now());this.#p+=1,this.#E=e,this.#P(e);let o=this.#S(e),s=this.#T(e.pose.eye,r);await this.#N(s),this.#s.look(o);let{renderer:i,decoding:a}=this.#o,{texels:c}=i,u=()=>i.hasEffects&&s.some(x=>c.isSpecular(x)),l=u(),d=(x,Y)=>l||this.#s.sees(x,Y),f=s.map(x=>this.#a.get(x)),h=[],m=(x,Y,C)=>{let V={shown:0,ready:0,working:0,missing:0,broken:0};return f.forEach(k1=>k1[x](Y,{sees:d,fetch:C,counts:V})),V},p=[r,r+(t?C3:0)];a.frames={shown:this.#d.shown??r,next:p};let w=m("prepare",r,h),y=this.#d.show(w.missing+w.working===0,t,performance.now());a.frames={shown:y,next:p};let v=m("ask",y,h);for(let x=r+1;x<=p[1];x+=1)m("prepare",x,[]);let E={...e,frame:y};this.#u=this.#O(E,s,h);let $=[...new Set([r,y])].flatMap(x=>this.#_(s,d,[x,x]));a.store.want([...h,...this.#F({...e,frame:r},s,o)],$);for(let x of f){let{units:Y,pixels:C,behind:V}=x.update();v.working+=V,this.#k.cells_decoded+=Y,this.#k.pixels_decoded+=C}return c.update(),v.working+=Number(u()&&!l),v.working>0&&a.pool.pending===0&&this.#w(),{view:E,active:s,cameras:o,counts:y===r?v:w}}#O({overlays:e,frame:t},r,o){if(!e.has("nodes"))return this.#c.clear(),0;let s=[];for(let{depth:i}of r.flatMap(a=>this.#r.views[a].faces))for(let a=0;a<this.#t.unitCount(i.index);a+=1){let c=this.#s.sees(i,a)&&Tt(this.#t,i.index,a,t);c&&s.push({...c,stream:i.index})}return this.#c.show(s,o)}#S(e){let[t,r]=e.size,o=e.stereo==="side-by-side",s=Ko(e.pose,e.fovDeg,(o?t/2:t)/r);return e.stereo==="mono"?[s]:Xo(s,e.eyeDistance)}#P({pose:{eye:e}}){let t=performance.now(),r=this.#h;if(r===void 0)this.#h={eye:[...e],ms:t,velocity:[0,0,0]};else if(r.eye.join()!==e.join()){let o=Math.max((t-r.ms)/1e3,.01),s=k(z(e,r.eye),1/o);this.#h={eye:[...e],ms:t,velocity:T(s)<=N3?s:[0,0,0]}}else t-r.ms>F3&&(r.velocity=[0,0,0])}#M(e){let t=this.#r.views.flatMap(W1);if(t.some(([o,s])=>o<=e&&e<=s))return e;let r=t.map(([,o])=>o).filter(o=>o<e);return r.length>0?Math.max(...r):Math.min(...t.map(([o])=>o))}#T(e,t){let r=this.#r.views.flatMap((o,s)=>{let{position:i}=this.#t.probeAt(o.probe,t);return as(o,t)?[{view:s,position:i}]:[]});return us(r,e,this.#l)}async#N(e){for(let t of e.filter(r=>!this.#a.has(r))){for(;this.#a.size>=this.#l;){let r=[...this.#a].filter(([i])=>!e.includes(i)),[o,s]=r.reduce((i,a)=>a[1].lastUsed<i[1].lastUsed?a:i);s.unload(),this.#a.delete(o)}this.#a.set(t,await i1.load(this.#o,t,this.#r.views[t]))}e.forEach(t=>this.#a.get(t).lastUsed=this.#p)}#F(e,t,r){let{frame:o}=e,s=[],i=this.#h?.velocity??[0,0,0];if(T(i)>0){let a=K(e.pose.eye,k(i,P3));this.#i.look(r.map(c=>({...c,eye:a}))),s.push(...this.#_(t,(c,u)=>this.#i.sees(c,u),[o,o]))}if(e.playing){let a=o+Math.ceil(O3*this.film.framesPerSecond),c=this.#_(t,(u,l)=>this.#s.sees(u,l),[o+1,a]);s.push(...c.sort((u,l)=>u.firstFrame-l.firstFrame))}return s}#_(e,t,r){let o=[];for(let s of e.flatMap(i=>this.#r.views[i].faces).flatMap(we))for(let i=0;i<this.#t.unitCount(s.index);i+=1)if(t(s,i)){let[a,c]=this.#t.chunksAmong(s.index,i,r);o.push(...this.#t.chunks.slice(a,c))}return o}#R({view:e,active:t,cameras:r}){let o=performance.now(),s=a=>{let c=this.#f.get(ne(this.#t.chunks[a]));return c!==void 0&&o-c<U3},i=(a,c)=>this.#c.of(a,c);return this.#e.draw({view:e,cameras:r,views:t,isFresh:s,codings:i},()=>this.onShown())}};var ni=2**28,oi=2**30,G3=12,ii=24,z3=[137,80,78,71,13,10,26,10];function $3(n,e){let t=new DataView(n.buffer,n.byteOffset,n.byteLength);if(!(n.length>=ii&&z3.every((s,i)=>n[i]===s))||t.getUint32(12)!==1229472850)throw new _(`${e} is no PNG picture.`);let o=[t.getUint32(16),t.getUint32(20)];if(o[0]===0||o[1]===0||o[0]*o[1]>ni)throw new g(`${e} has ${o[0]}x${o[1]} pixels; the player shows up to ${ni}.`);return o}function si(n,e,t){let r=Math.floor(t[0]/e.columns),o=Math.floor(t[1]/e.rows),s=e.rows-1-Math.floor(n/e.columns);return[n%e.columns*r,s*o,r,o]}function V3(n,e){let t=Math.min(n[0],n[1]*e);return[Math.max(1,Math.round(t)),Math.max(1,Math.round(t/e))]}async function ai(n,e,{name:t,layout:r}){if(n.byteCount>oi)throw new g(`The quilt has ${n.byteCount} bytes; the player reads up to ${oi}.`);let o=performance.now(),s=await n.read(0,n.byteCount),i=$3(s.subarray(0,ii),"The quilt");if(i[0]<r.columns||i[1]<r.rows)throw new _(`The quilt has fewer pixels than its ${r.columns}x${r.rows} tiles.`);let a=await createImageBitmap(new Blob([s],{type:"image/png"})).catch(()=>{throw new _("The quilt is a damaged PNG picture, or one that this browser does not read.")}),c=document.createElement("canvas");[,,c.width,c.height]=si(0,r,i);let[u,l]=[e.getContext("2d"),c.getContext("2d")];if(u===null||l===null)throw new g("The browser has no memory for a picture.");let d=performance.now()-o,f=r.columns*r.rows,h={eye:[0,0,0],yaw:0,pitch:0},m=w=>({counters:{views:f,width:i[0],height:i[1]},decodeMs:d,marchMs:0,fetchRate:0,bytesFetched:s.length,requests:1,chunksFetched:1,chunksRefetched:0,cacheBytes:4*i[0]*i[1],unitsMissing:0,unitsBroken:0,overlayMissing:0,shownFrame:w}),p={film:{name:t,fileBytes:n.byteCount,framesPerSecond:G3,firstFrame:0,frameCount:f,headBox:{least:[0,0,0],greatest:[0,0,0]},probes:[],start:{...h,eye:[0,0,0]},streams:[{kind:"quilt",codec:"PNG",count:f,bytes:s.length}]},draw(w){let[y,v]=V3(w.size,r.aspect);[e.width,e.height]=[y,v];let[E,$]=si(w.frame,r,i);return l.clearRect(0,0,c.width,c.height),l.drawImage(a,-E,-$),u.imageSmoothingQuality="high",u.drawImage(c,0,0,y,v),p.onShown(),Promise.resolve(m(w.frame))},settle:()=>Promise.resolve(),fetched:()=>[[0,f-1]],pixels(){let{data:w}=u.getImageData(0,0,e.width,e.height),y=Float32Array.from(w,(v,E)=>E%4===3?v/255:He(v,"srgb"));return Promise.resolve({size:[e.width,e.height],rgba:y})},onProblem:()=>{},onShown:()=>{},close:()=>a.close()};return p}var W3=["probes","nodes","holes","units","keyframes","fetched"],j3="./glb.js";async function q3(n,e){let t=await je(()=>Ce.open(n.url)),{openScene:r}=await import(j3),o=await r(t,e,n.name),s={player:o,marks:["overdraw"],isFixed:!1,showOverdraw:i=>o.showOverdraw(i)};return await o.hasHeadset()&&(s.enterHeadset=i=>o.enterHeadset(i)),s}async function ci(n,e,t){if(n.kind==="glb")return q3(n,e);let r=await je(()=>Ce.open(n.url));if(n.kind==="lfold")return{player:await ri(r,e,t),marks:W3,isFixed:!1};if(n.quilt===void 0)throw new A("film.json, quilt: columns and rows were expected.");return{player:await ai(r,e,{name:n.name,layout:n.quilt}),marks:[],isFixed:!0}}function c1({least:n,greatest:e}){let t=n.map((r,o)=>e[o]-r);return Math.max(.1*Math.max(...t),.1)}function ui(n,e,[t,r],o){if(e<0)return-ui(-n,-e,[-r,-t],o);let s=Math.min(e,Math.max(r-n,0)),i=r+o,a=e-s;if(a===0)return n+s;let c=Math.max(n,r);return i-Math.max(i-c,0)*Math.exp(-a/o)}function li(n,e,t){let r=c1(t),o=s=>ui(n[s],e[s],[t.least[s],t.greatest[s]],r);return[o(0),o(1),o(2)]}function qe(n,e){let t=c1(e),r=o=>Math.min(Math.max(n[o],e.least[o]-t),e.greatest[o]+t);return[r(0),r(1),r(2)]}var di=[.0002777777777777778,1e4];function K3(n){return Math.min(Math.max(n||0,di[0]),di[1])}var u1=class{#e;#t=0;#r=0;#n=!1;#o=1;isLooped=!0;constructor(e){this.#e={...e,framesPerSecond:K3(e.framesPerSecond)}}get isPlaying(){return this.#n}get lastFrame(){return this.#e.firstFrame+this.#e.frameCount-1}frame(e){let{firstFrame:t,frameCount:r}=this.#e,o=this.#i(e);return o>=r&&(this.isLooped?o%=r:(o=r-1,this.#n=!1),this.#t=o,this.#r=e),t+Math.floor(o)}play(e){let t=!this.isLooped&&this.frame(e)===this.lastFrame;this.#s(t?0:this.#i(e),e),this.#n=this.#e.frameCount>1}pause(e){this.#s(this.frame(e)-this.#e.firstFrame,e),this.#n=!1}seek(e,t){let r=Math.round(e)-this.#e.firstFrame;this.#s(Math.min(Math.max(r,0),this.#e.frameCount-1),t)}step(e,t){this.pause(t);let{frameCount:r}=this.#e,o=this.#t+e,s=(o%r+r)%r;this.#t=this.isLooped?s:Math.min(Math.max(o,0),r-1)}setSpeed(e,t){this.#s(this.#i(t),t),this.#o=e}#s(e,t){this.#t=e,this.#r=t}#i(e){let t=this.#n?Math.max(e-this.#r,0):0;return this.#t+t/1e3*this.#o*this.#e.framesPerSecond}};var Ke=89*Math.PI/180;function fr({yaw:n,pitch:e}){return[-Math.sin(n)*Math.cos(e),Math.sin(e),-Math.cos(n)*Math.cos(e)]}function X3({yaw:n}){return[Math.cos(n),0,-Math.sin(n)]}function hr(n){let e=Math.round(n/(2*Math.PI));return n-e*2*Math.PI}function fi(n,e,t){let r=Math.min(Math.max(n.pitch+t,-Ke),Ke);return{eye:n.eye,yaw:hr(n.yaw+e),pitch:r}}function hi(n,[e,t,r]){let o=X3(n),s=fr(n);return[e*o[0]+r*s[0],e*o[1]+t+r*s[1],e*o[2]+r*s[2]]}var L={exposureEv:0,toneMap:"none",fovDeg:60,stereo:"mono",eyeDistance:.063,steps:1024,scale:1,speed:1,isLooped:!0,marks:new Set,renderer:"auto"},Y3={exposureEv:[-10,10],fovDeg:[20,120],eyeDistance:[0,.5],steps:[32,4096],scale:[.125,1],speed:[.25,2]},l1=["none","reinhard","filmic"],d1=["mono","side-by-side","anaglyph"],f1=["auto","gpu","cpu"],mr=["probes","nodes","holes","units","keyframes","fetched","overdraw"];function oe(n,e){let[t,r]=Y3[n],o=Math.min(Math.max(e,t),r);return n==="steps"?Math.round(o):o}var Q3=2e3,J3=1e9,Z3=/^-?(\d+(\.\d*)?|\.\d+)(e[+-]?\d{1,2})?$/i,pi=[["ev","exposureEv"],["fov","fovDeg"],["eyes","eyeDistance"],["steps","steps"],["scale","scale"],["speed","speed"]];function br(n){return n!==null&&n.length<=40&&Z3.test(n)?Number(n):void 0}function mi(n,e,t){let o=(n?.split(",",e+1)??[]).map(br),s=i=>i!==void 0&&Math.abs(i)<=t;return o.length===e&&o.every(s)?o:void 0}function pr(n,e){return n.find(t=>t===e)}function el(n){if(n===null)return;let e=new Set(n.split(","));return new Set(mr.filter(t=>e.has(t)))}function tl(n){return Object.fromEntries(Object.entries(n).filter(([,e])=>e!==void 0))}function Xe(n){if(n.length>Q3)return{settings:{}};let e=new URLSearchParams(n.replace(/^#/,"")),t=mi(e.get("eye"),3,J3),r=mi(e.get("look"),2,1e6),o=br(e.get("frame")),s=tl({toneMap:pr(l1,e.get("tone")),stereo:pr(d1,e.get("stereo")),isLooped:e.get("loop")===null?void 0:e.get("loop")!=="0",marks:el(e.get("show")),renderer:pr(f1,e.get("renderer"))});for(let[a,c]of pi){let u=br(e.get(a));u!==void 0&&(s[c]=oe(c,u))}let i={settings:s};if(t!==void 0&&(i.eye=t),r!==void 0){let[a,c]=r.map(u=>u*Math.PI/180);i.look=[hr(a),Math.min(Math.max(c,-Ke),Ke)]}return o!==void 0&&Number.isSafeInteger(o)&&o>=0&&(i.frame=o),i}function I(n,e){return String(Number(n.toFixed(e))+0)}function bi(n,e,t){let r=[n.yaw,n.pitch].map(i=>I(i*180/Math.PI,3)),o=[`eye=${n.eye.map(i=>I(i,5)).join(",")}`,`look=${r.join(",")}`];o.push(`frame=${e}`);let s=(i,a,c)=>{a!==c&&o.push(`${i}=${a}`)};for(let[i,a]of pi)s(i,I(t[a],4),I(L[a],4));return s("tone",t.toneMap,L.toneMap),s("stereo",t.stereo,L.stereo),s("loop",t.isLooped?"1":"0",L.isLooped?"1":"0"),s("renderer",t.renderer,L.renderer),s("show",mr.filter(i=>t.marks.has(i)).join(","),""),`#${o.join("&")}`}var wi=/[\u0000-\u001f\u007f-\u009f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/;function rl(n){return[...new TextEncoder().encode(n)].map(t=>`\\${t.toString(8).padStart(3,"0")}`).join("")}function nl(n){let e=n.startsWith("-")?`./${n}`:n;return wi.test(e)?`$'${e.replace(/[\\']/g,"\\$&").replace(new RegExp(wi,"g"),rl)}'`:`'${e.replaceAll("'","'\\''")}'`}function wr(n,e){let t=["lightfold","render",nl(n)];if(e!==void 0){let{pose:r,stereo:o}=e,s=fr(r),i=c=>c.map(u=>I(u,5)).join(",");t.push("--eye",i(r.eye)),t.push("--look-at",i(r.eye.map((c,u)=>c+s[u]))),t.push("--fov",I(e.fovDeg,3));let a=o==="side-by-side"?2:1;t.push("--size",`${Math.max(1,Math.round(e.size[0]/a))}x${e.size[1]}`),a===2&&t.push("--stereo","side-by-side","--eye-distance",I(e.eyeDistance,4)),e.frame!==void 0&&t.push("--frames",String(e.frame))}return t.push("-o","view.png"),t.join(" ")}var ol=new Map([[" ","play"],["k","play"],[",","step-back"],[".","step-forward"],["Home","first"],["End","last"],["l","loop"],["[","slower"],["]","faster"],["0","reset"],["r","reset"],["m","lock-pointer"],["v","settings"],["i","inspector"],["h","help"],["?","help"],["f","full-screen"],["c","screenshot"]]),yr=new Set(["Home","End","ArrowLeft","ArrowRight","ArrowUp","ArrowDown"]),gi=new Set([...yr," ","Enter"]),sl={picture:new Set,panel:yr,slider:yr,widget:gi,text:gi};function _r(n,e){return!(n.ctrlKey||n.altKey||n.metaKey)&&e!=="text"&&!sl[e].has(n.key)}function yi(n,e){let t=n.key.length===1?n.key.toLowerCase():n.key;return _r(n,e)?ol.get(t):void 0}var _i=new Map([["KeyW",[0,0,1]],["KeyS",[0,0,-1]],["KeyA",[-1,0,0]],["KeyD",[1,0,0]],["KeyE",[0,1,0]],["KeyQ",[0,-1,0]]]),vi=new Map([["ArrowLeft",[1,0]],["ArrowRight",[-1,0]],["ArrowUp",[0,1]],["ArrowDown",[0,-1]]]);function xi(n){return _i.has(n)||vi.has(n)}function vr(n){let e={step:[0,0,0],turn:[0,0]};for(let t of n)_i.get(t)?.forEach((r,o)=>e.step[o]+=r),vi.get(t)?.forEach((r,o)=>e.turn[o]+=r);return e}var gr=.15;function h1(n){let e=Math.abs(n??0);return e<gr?0:Math.sign(n??0)*Math.min((e-gr)/(1-gr),1)}function ki({axes:n,buttons:e}){let t=(e[7]?.value??0)-(e[6]?.value??0);return{step:[h1(n[0]),t,-h1(n[1])],turn:[-h1(n[2]),-h1(n[3])]}}var Ei=[[0,"play"],[3,"reset"],[4,"step-back"],[5,"step-forward"]];function Si(n){let e=[...n],t=e.reduce((s,i)=>s+i.x,0)/e.length,r=e.reduce((s,i)=>s+i.y,0)/e.length,o=e.reduce((s,i)=>s+Math.hypot(i.x-t,i.y-r),0)/e.length;return{x:t,y:r,spread:o}}var m1=class{#e;#t;#r=new Map;constructor(e,t){this.#e=e,this.#t=t,e.addEventListener("pointerdown",o=>this.#n(o)),e.addEventListener("pointermove",o=>this.#s(o));let r=o=>this.#o(o);e.addEventListener("pointerup",r),e.addEventListener("pointercancel",r),e.addEventListener("dblclick",()=>this.toggleLock()),e.addEventListener("wheel",o=>this.#i(o),{passive:!1})}toggleLock(){if(document.pointerLockElement===this.#e){document.exitPointerLock();return}this.#e.requestPointerLock()?.catch(()=>{})}#n(e){e.button!==0||document.pointerLockElement===this.#e||(this.#e.setPointerCapture(e.pointerId),this.#r.set(e.pointerId,{x:e.clientX,y:e.clientY}),this.#e.classList.add("dragged"))}#o(e){this.#r.delete(e.pointerId),this.#e.classList.toggle("dragged",this.#r.size>0)}#s(e){if(document.pointerLockElement===this.#e){let c=.0022*this.#t.fovDeg()/60;this.#t.turn(-e.movementX*c,-e.movementY*c);return}let t=this.#e.getBoundingClientRect();if(this.#t.hover(Math.min(Math.max((e.clientX-t.left)/Math.max(t.width,1),0),1)),!this.#r.has(e.pointerId))return;let r=Si(this.#r.values());this.#r.set(e.pointerId,{x:e.clientX,y:e.clientY});let o=Si(this.#r.values()),[s,i]=[o.x-r.x,o.y-r.y],a=Math.max(t.height,1);if(this.#r.size===1){let c=this.#t.fovDeg()*Math.PI/180/a;this.#t.turn(s*c,i*c)}else{let c=this.#t.reach()/a;this.#t.move([-s*c,i*c,2*(o.spread-r.spread)*c])}}#i(e){if(e.ctrlKey)return;e.preventDefault();let t=e.deltaMode===WheelEvent.DOM_DELTA_PIXEL?e.deltaY:e.deltaY*32;this.#t.zoom(Math.exp(Math.min(Math.max(t,-300),300)*.001))}};var il=70,al=4,Ri=.5;function cl(n){return CSS.supports("selector(:open)")&&n.matches(":open")}function ul(n){if(!(n instanceof HTMLElement))return"picture";if(n instanceof HTMLSelectElement)return cl(n)?"text":"widget";if(n instanceof HTMLInputElement){let e=["checkbox","radio","button"].includes(n.type);return n.type==="range"?"slider":e?"widget":"text"}return n.matches("aside, aside h2")?"panel":n.closest("button, a, summary, pre, aside")===null?"picture":"widget"}var p1=class{#e;#t;#r=new Map;#n=0;#o=new Set;#s=!1;constructor(e,t){this.#e=t,this.#t=new m1(e,t),window.addEventListener("keydown",s=>this.#i(s)),window.addEventListener("keyup",s=>this.#a(s)),window.addEventListener("blur",()=>{this.#r.clear(),this.#s=!1});let r=!1;window.addEventListener("pointerdown",()=>r=!0,{capture:!0}),window.addEventListener("keydown",()=>r=!1,{capture:!0});let o=({target:s},i)=>{r&&s instanceof Element&&s.closest(i)!==null&&e.focus({preventScroll:!0})};window.addEventListener("click",s=>o(s,"#tools button:not([aria-expanded='true']), #transport button")),window.addEventListener("change",s=>o(s,"select"))}advance(e){let t=Math.min(Math.max(e,0),Ri);this.#n=performance.now(),this.#l(vr(this.#r.keys()),this.#s,t);for(let r of navigator.getGamepads?.()??[])r?.mapping==="standard"&&(this.#l(ki(r),r.buttons[10]?.pressed===!0,t),this.#f(r))}toggleLock(){this.#t.toggleLock()}#i(e){this.#s=e.shiftKey;let t=ul(e.target),r=yi(e,t);r!==void 0?(e.preventDefault(),(!e.repeat||r.startsWith("step"))&&this.#e.act(r)):xi(e.code)&&_r(e,t)&&(e.preventDefault(),this.#r.set(e.code,this.#r.get(e.code)??performance.now()))}#a(e){let t=this.#r.get(e.code);if(t!==void 0){let r=(performance.now()-Math.max(t,this.#n))/1e3;this.#l(vr([e.code]),this.#s,Math.min(Math.max(r,0),Ri)),this.#r.delete(e.code)}this.#s=e.shiftKey}#l({step:e,turn:t},r,o){if(e.some(s=>s!==0)){let s=Math.max(1,Math.hypot(...e)),i=(r?al:1)*this.#e.moveSpeed()*o/s;this.#e.move(e.map(a=>a*i))}if(t.some(s=>s!==0)){let s=il*Math.PI/180*o*this.#e.fovDeg()/60;this.#e.turn(t[0]*s,t[1]*s)}}#f(e){for(let[t,r]of Ei){let o=`${e.index} ${t}`,s=e.buttons[t]?.pressed===!0;s&&!this.#o.has(o)?(this.#o.add(o),this.#e.act(r)):s||this.#o.delete(o)}}};var ll="http://www.w3.org/2000/svg",dl=2e3,fl=.011,hl=.02,ml=.3;function Me(n,e,t){let r=document.createElementNS(ll,e);return Object.entries(t).forEach(([o,s])=>r.setAttribute(o,String(s))),n.appendChild(r)}var b1=class{#e;#t=1;#r={least:[0,0,0],greatest:[0,0,0]};#n;#o;constructor(e){this.#e=e}setFilm({headBox:e,probes:t}){this.#r=e;let r=c1(e),[o,,s]=e.least,[i,a]=[e.greatest[0]-o,e.greatest[2]-s],c=1.15*(Math.max(i,a)+2*r),u=[o+i/2,s+a/2];this.#t=c,this.#e.replaceChildren();let l=100/c;this.#e.setAttribute("viewBox",[-80,-50,160,100].join(" "));let d=Me(this.#e,"g",{transform:`scale(${l}) translate(${-u[0]} ${-u[1]})`}),f=h=>({x:o-h,y:s-h,width:i+2*h,height:a+2*h});Me(d,"rect",{...f(r),class:"margin"}),Me(d,"rect",{...f(0),class:"box"});for(let{position:h}of t.slice(0,dl))Me(d,"circle",{cx:h[0],cy:h[2],r:c*fl,class:"probe"});this.#n=Me(d,"path",{class:"cone"}),this.#o=Me(d,"circle",{r:c*hl,class:"eye"})}showPose({eye:e,yaw:t},r){let[o,,s]=qe(e,this.#r),i=Math.min(r,170)*Math.PI/360,a=c=>{let u=this.#t*ml;return`${o-Math.sin(c)*u} ${s-Math.cos(c)*u}`};this.#n?.setAttribute("d",`M${o} ${s}L${a(t+i)}L${a(t-i)}Z`),this.#o?.setAttribute("cx",String(o)),this.#o?.setAttribute("cy",String(s))}};function pl({stats:n,pictureMs:e,size:t},r){let o=[["Picture",et(e)],["Decoding",et(n.decodeMs)]];return r!=="quilt"&&o.push(["Rendering",et(n.marchMs)]),o.push(["Size",`${t[0]}×${t[1]}`]),r==="lfold"&&o.push(["Frame shown",String(n.shownFrame)],["Tiles and cells not loaded",D(n.unitsMissing)],["Tiles and cells damaged",D(n.unitsBroken)],["Rate",`${(n.fetchRate/1e6).toFixed(2)} MB/s`],["Requests",D(n.requests)],["Chunks",D(n.chunksFetched)],["Chunks fetched again",D(n.chunksRefetched)]),o.push(["Fetched",ie(n.bytesFetched)],["Cache",ie(n.cacheBytes)]),o}function xr(n){let e=b(n,HTMLTableElement);return e.tBodies[0]??e.createTBody()}function bl(){let n=K1.map(({color:e,name:t})=>{let r=document.createElement("li"),o=r.appendChild(document.createElement("span"));return o.style.backgroundColor=`rgb(${e.join()})`,r.append(t),r});b("nodes-legend",HTMLUListElement).prepend(...n)}var w1=class{#e=new b1(b("map",SVGSVGElement));#t=[...b("marks",HTMLFieldSetElement).querySelectorAll("input")];#r=b("command",HTMLElement);#n;constructor(e,t){this.#n=e;for(let o of this.#t)o.addEventListener("change",()=>t(o.value,o.checked));bl();let r=P("copy-command",()=>{ae(this.#r.textContent??"",r,this.#r)})}setFilm(e,t){this.#e.setFilm(e),b("marks",HTMLElement).hidden=t.length===0;for(let o of this.#t){let s=o.closest("label");s!==null&&(s.hidden=!t.some(i=>i===o.value))}let r=e.streams.map(({kind:o,codec:s,count:i,bytes:a})=>[o,s,D(i),ie(a)]);Ze(xr("streams"),r)}showMarks(e){for(let t of this.#t)t.checked=[...e].some(r=>r===t.value)}show(e){let{pose:t,stats:r}=e;Ze(xr("figures"),pl(e,this.#n));let o=Object.entries(r.counters).map(([a,c])=>[a,D(c)]);Ze(xr("counters"),o),this.#e.showPose(t,e.fovDeg);let s=[t.yaw,t.pitch].map(a=>`${(a*180/Math.PI).toFixed(1)}°`),i=t.eye.map(a=>(Number(a.toFixed(3))+0).toFixed(3)).join("  ");R(b("eye",HTMLElement),`Eye ${i} m
Yaw ${s[0]}  Pitch ${s[1]}`),R(this.#r,e.command??""),b("command-part",HTMLElement).hidden=e.command===void 0}};var kr=class{#e=.25;factor(e){return e?this.#e:1}note(e,t){e>this.#e?this.#e=t<=100?e:this.#e:e===this.#e&&t>100?this.#e=Math.max(e/2,.125):e===this.#e&&t<20&&(this.#e=Math.min(e*2,1))}},g1=class{#e;#t=new kr;#r=!0;#n=!0;#o=!1;#s=!1;#i=!1;#a=0;#l=-1/0;#f=-1/0;constructor(e){this.#e=e}change(){this.#r=!0}move(){this.#r=!0,this.#f=this.#e.now()}get isStill(){return this.#e.now()-this.#f>=180}get isSettled(){return!this.#s&&!this.#r&&!this.#n&&this.#a===1}tick(){let e=this.#e.now(),t=this.#t.factor(!this.isStill||this.#n),r=(this.#n||this.#o)&&e-this.#l>=100;this.#s||this.#i||!(this.#r||r||t>this.#a)||this.#c(t,e)}async#c(e,t){this.#s=!0,this.#r=!1;try{let r=await this.#e.draw(e);this.#l=this.#e.now(),this.#a=e,this.#n=r.unitsMissing>0,this.#o=r.overlayMissing>0,(r.unitsMissing===0||r.marchMs>0)&&this.#t.note(e,this.#l-t),this.#e.onDrawn(r,this.#l-t)}catch(r){this.#i=!0,this.#e.onFailed(r)}finally{this.#s=!1}}};var wl=/[^\p{L}\p{N}._-]+/gu;function Ai(n,e){return`${n.replace(/\.[a-z0-9]{1,8}$/i,"").replace(wl,"_").replace(/^[._-]+|[._-]+$/g,"").slice(0,100)||"film"}_${String(e).padStart(4,"0")}.png`}async function Mi(n,e){let t=document.createElement("canvas");[t.width,t.height]=[n.width,n.height],t.getContext("2d")?.drawImage(n,0,0);let r=await new Promise(s=>t.toBlob(s,"image/png"));if(r===null)throw new Error("The picture cannot be saved: the browser gives no memory for it.");let o=document.createElement("a");o.href=URL.createObjectURL(r),o.download=e,o.click(),setTimeout(()=>URL.revokeObjectURL(o.href),1e4)}var Ti=[["exposureEv","exposure",n=>`${n>0?"+":""}${I(n,2)}`],["fovDeg","fov",n=>`${I(n,1)}°`],["eyeDistance","eye-distance",n=>`${I(n*1e3,0)} mm`]],Ci=[["scale","scale"],["steps","steps"],["speed","speed"]];function gl(n,e){[...n.options].some(t=>t.value===e)||n.add(new Option(e,e)),n.value=e}function Er(n,e,t){let r=b(n,HTMLSelectElement);r.addEventListener("change",()=>{let o=e.find(s=>s===r.value);o!==void 0&&t(o)})}var y1=class{constructor(e){for(let[t,r]of Ti){let o=b(r,HTMLInputElement);o.addEventListener("input",()=>e({[t]:oe(t,Number(o.value))}))}for(let[t,r]of Ci){let o=b(r,HTMLSelectElement);o.addEventListener("change",()=>e({[t]:oe(t,Number(o.value))}))}Er("tone-map",l1,t=>e({toneMap:t})),Er("stereo",d1,t=>e({stereo:t})),Er("renderer",f1,t=>e({renderer:t})),P("reset-settings",()=>{let{exposureEv:t,toneMap:r,fovDeg:o,stereo:s,eyeDistance:i,steps:a,scale:c}=L;e({exposureEv:t,toneMap:r,fovDeg:o,stereo:s,eyeDistance:i,steps:a,scale:c})})}show(e){for(let[t,r,o]of Ti)b(r,HTMLInputElement).value=String(e[t]),b(r,HTMLInputElement).setAttribute("aria-valuetext",o(e[t])),R(b(`${r}-value`,HTMLOutputElement),o(e[t]));for(let[t,r]of Ci)gl(b(r,HTMLSelectElement),String(e[t]));b("tone-map",HTMLSelectElement).value=e.toneMap,b("stereo",HTMLSelectElement).value=e.stereo,b("renderer",HTMLSelectElement).value=e.renderer,b("eye-distance",HTMLInputElement).disabled=e.stereo==="mono",b("loop",HTMLButtonElement).setAttribute("aria-pressed",String(e.isLooped))}};var yl=["settings","inspector","help"],_1=class{#e=b("side",HTMLElement);#t=b("stage",HTMLElement);#r;#n;#o;constructor(e){this.#r=e,this.#e.addEventListener("keydown",t=>{t.key==="Escape"&&this.#n!==void 0&&this.toggle(this.#n)})}get open(){return this.#n}restore(){this.#e.hidden=this.#n===void 0}toggle(e){if(b(`open-${e}`,HTMLButtonElement).hidden)return;let t=document.activeElement,r=this.#e.contains(t);r||(this.#o=t instanceof HTMLElement&&t!==document.body?t:this.#t),this.#n=this.#n===e?void 0:e,this.restore();for(let o of yl)b(o,HTMLElement).hidden=o!==this.#n,b(`open-${o}`,HTMLButtonElement).setAttribute("aria-expanded",String(o===this.#n));if(this.#n!==void 0){let o=b(`${e}-title`,HTMLElement);this.#e.setAttribute("aria-labelledby",o.id),this.#e.scrollTop=0,o.focus()}else r&&this.#o?.focus();this.#r()}};function Oi(n,e,t){return t>1?(n-e)/(t-1):0}function _l(n,[e,t],r){let o=r-14,s=[];for(let[i,a]of n){let c=Math.max(i,e),u=Math.min(a,e+t-1);if(c<=u){let l=7+o*Math.max(Oi(c-.5,e,t),0),d=7+o*Math.min(Oi(u+.5,e,t),1);s.push(t>1?[l,d-l]:[7,o])}}return s}function vl(n,e){let t=Math.max(1,Math.round(e)),r=Math.floor(n/t),o=i=>String(i).padStart(2,"0"),s=Math.floor(r/60);return[Math.floor(s/60),s%60,r%60,n%t].map(o).join(":")}var v1=class{#e;#t=0;#r=1;#n=24;#o="Frame";#s="";constructor(e,t){this.#e=e,e.slider.addEventListener("input",()=>t(Number(e.slider.value)))}setFilm({firstFrame:e,frameCount:t,framesPerSecond:r},o){[this.#t,this.#r,this.#n]=[e,t,r],this.#o=o;let{slider:s,time:i}=this.#e;s.min=String(e),s.max=String(e+t-1),s.disabled=t<2,s.ariaLabel=o,i.hidden=o==="View",this.#s=""}showFrame(e,t){let{slider:r,label:o,time:s}=this.#e,i=t===e?"":` (shown: ${t})`,a=`${this.#o} ${e} of ${this.#t}–${this.#t+this.#r-1}`;o.textContent!==a&&(r.value=String(e),o.textContent=a,s.textContent=` · ${vl(e-this.#t,this.#n)}`),r.setAttribute("aria-valuetext",`${this.#o} ${e}${i}`)}showFetched(e){let{canvas:t}=this.#e,[r,o]=[t.clientWidth,t.clientHeight],s=window.devicePixelRatio,i=JSON.stringify([e,r,o,s]),a=t.getContext("2d");if(!(i===this.#s||a===null)){this.#s=i,t.width=Math.round(r*s),t.height=Math.round(o*s),a.scale(s,s),a.fillStyle=getComputedStyle(t).color;for(let[c,u]of _l(e,[this.#t,this.#r],r))a.fillRect(c,0,u,o)}}};var xl=400,kl=200,El=8192,Sl=.4,Pi=[.15,3],Rl=1e4,Al=15e3,Ml=400,Ye=[.25,.5,1,1.5,2],x1=class{#e;#t;#r=b("stage",HTMLElement);#n=new tt;#o=new ue(()=>{this.load()},()=>{this.#v({renderer:"cpu"}),this.load()});#s=new _1(()=>this.#g=-1/0);#i=new y1(e=>this.#v(e));#a;#l;#f;#c={...L};#u;#d;#h;#m;#x=!1;#b;#p=!0;#k=!1;#E=0;#w=-1/0;#g=-1/0;#y=-1/0;constructor(e,t){this.#e=e,this.#t=t,this.#a=new w1(e.kind,(s,i)=>this.#z(s,i)),document.title=`⁨${e.name}⁩ · lightfold`;let r=b("film-name",HTMLElement);r.title=e.name,R(r,e.name);let o={slider:b("timeline",HTMLInputElement),canvas:b("fetched",HTMLCanvasElement),label:b("frame-label",HTMLElement),time:b("time-code",HTMLElement)};this.#l=new v1(o,s=>this.#C(s)),this.#f=new p1(this.#r,{act:s=>this.#L(s),turn:(s,i)=>this.#D(s,i),move:s=>this.#H(s),zoom:s=>this.#v({fovDeg:oe("fovDeg",this.#c.fovDeg*s)}),hover:s=>this.#G(s),fovDeg:()=>this.#c.fovDeg,moveSpeed:()=>this.#I(),reach:()=>this.#I()*2}),this.#W(),this.#c={...L,...Xe(location.hash).settings},this.#i.show(this.#c),this.#a.showMarks(this.#c.marks),window.addEventListener("hashchange",()=>this.#$()),new ResizeObserver(()=>this.#u?.loop.change()).observe(this.#r),requestAnimationFrame(s=>this.#M(s))}async load(){if(this.#x)return;this.#x=!0;let{renderer:e}=this.#c;this.#b=e,this.#S(),this.#o.opening(this.#e.name);let t=document.createElement("canvas");this.#r.replaceChildren(t);try{this.#A(await this.#t(this.#e,t,e),t),this.#o.hide(),this.#s.restore()}catch(r){this.#S(),this.#r.replaceChildren(),R(b("film-facts",HTMLElement),""),this.#o.failed(r,this.#R()),this.#d!==void 0&&this.#U(this.#h??0)}finally{this.#x=!1}this.#e.kind==="lfold"&&e!==this.#c.renderer&&await this.load()}#A(e,t){let{player:r}=e,{film:o}=r,s=new u1(o),i=d=>{this.#u?.player===r&&this.#P(d)},a=performance.now(),c=!1,u=new g1({draw:d=>(c=d===1,r.draw(this.#F(d))),onDrawn:(d,f)=>{this.#u?.player===r&&(this.#m={stats:d,pictureMs:f,size:[t.width,t.height]},this.#p||=performance.now()-a>Rl)},onFailed:d=>i({fatal:!0,message:ce(d)}),now:()=>performance.now()});this.#u={...e,canvas:t,loop:u,clock:s},r.onProblem=i,r.onShown=()=>{this.#k&&(c||s.isPlaying)&&(this.#k=!1,this.#T(t))};let l=Xe(location.hash);this.#d??=this.#B(o.start,l),this.#d={...this.#d,eye:qe(this.#d.eye,o.headBox)},s.isLooped=this.#c.isLooped,s.setSpeed(this.#c.speed,performance.now()),s.seek(this.#h??l.frame??o.firstFrame,performance.now()),this.#O(e),e.showOverdraw?.(this.#c.marks.has("overdraw"))}#O({player:{film:e,renderer:t},marks:r,isFixed:o,enterHeadset:s}){let i=e.frameCount<2,a=this.#e.kind==="quilt";Tl(this.#e.kind),this.#r.classList.toggle("fits",o),a&&(this.#r.ariaDescription="The pointer chooses the view, Space plays, H opens help."),["transport","help-playing"].forEach(p=>b(p,HTMLElement).hidden=i),b("headset",HTMLButtonElement).hidden=s===void 0,this.#l.setFilm(e,a?"View":"Frame"),this.#a.setFilm(e,r),b("steps",HTMLSelectElement).disabled=t==="cpu";let c=Number(e.framesPerSecond.toFixed(3)),u=a?`${e.frameCount} views`:`${e.frameCount} frames at ${c}/s`,l=i?"still":u,{length:d}=e.probes,f=d===0?[]:[`${D(d)} ${d===1?"probe":"probes"}`],h=b("film-facts",HTMLElement),m=t==="cpu"?["small pictures, drawn on the processor"]:[];h.title=[...f,l,ie(e.fileBytes),...m].join(" · "),R(h,h.title),R(b("headset-help",HTMLElement),Cl(this.#e,s!==void 0))}#S(){let e=this.#u;e!==void 0&&(this.#h=e.clock.frame(performance.now()),this.#u=void 0,this.#m=void 0,e.player.close())}#P({fatal:e,passes:t,message:r}){if(!e){this.#n.say(r,t===!0?Al:1/0);return}this.#S(),this.#p?(this.#p=!1,this.#n.say(`${r.replace(/\.$/,"")}; the film is loaded again`),this.load()):(this.#r.replaceChildren(),this.#o.failed(r,this.#R()))}#M(e){requestAnimationFrame(i=>this.#M(i));let t=(e-this.#E)/1e3;this.#E=e;let r=this.#u;if(r===void 0)return;this.#f.advance(t);let o=performance.now(),s=r.clock.frame(o);s!==this.#h&&(this.#h=s,r.loop.move()),this.#c.marks.has("fetched")&&(this.#m?.stats.fetchRate??0)>0&&r.loop.change(),r.loop.tick(),this.#r.ariaBusy=String(!r.loop.isSettled),this.#l.showFrame(s,this.#m?.stats.shownFrame??s),b("play",HTMLButtonElement).classList.toggle("playing",r.clock.isPlaying),b("play",HTMLButtonElement).ariaLabel=r.clock.isPlaying?"Pause":"Play",o-this.#g>=kl&&(this.#g=o,this.#N(r)),o-this.#w>=xl&&r.loop.isStill&&!r.clock.isPlaying&&(this.#w=o,this.#U(s))}#T(e){Mi(e,Ai(this.#e.name,this.#h??0)).catch(r=>this.#n.say(ce(r)))}#N(e){this.#l.showFetched(e.player.fetched());let t=this.#m?.stats.unitsMissing??0,r=b("state",HTMLElement),o=performance.now();if(this.#y=t===0?o:this.#y,r.hidden=this.#m!==void 0&&o-this.#y<Ml,R(r,this.#m?`${D(t)} tiles and cells not loaded yet`:"Loading the first picture"),this.#m!==void 0&&this.#d!==void 0&&this.#s.open==="inspector"){let[s,i]=this.#_(1),a=Math.tan(this.#c.fovDeg*Math.PI/360)*(s/i),c=2*Math.atan(a)*180/Math.PI;this.#a.show({...this.#m,pose:this.#d,fovDeg:c,command:this.#R()})}}#F(e){let{marks:t,fovDeg:r,stereo:o,eyeDistance:s,exposureEv:i,toneMap:a,steps:c}=this.#c,u=new Set((this.#u?.marks??[]).flatMap(m=>m!=="overdraw"&&t.has(m)?[m]:[])),[l,d,f]=[this.#d??Sr,this.#h??0,this.#_(e,this.#u?.player.mostPixels)],h=this.#u?.clock.isPlaying??!1;return{pose:l,frame:d,playing:h,size:f,fovDeg:r,stereo:o,eyeDistance:s,exposureEv:i,toneMap:a,overlays:u,steps:c}}#_(e,t=1/0){let[r,o]=[this.#r.clientWidth,this.#r.clientHeight],s=window.devicePixelRatio*this.#c.scale,i=e*Math.min(s,El/Math.max(r,o,1),Math.sqrt(t/(r*o)));return[Math.max(2,2*Math.round(r*i/2)),Math.max(1,Math.round(o*i))]}#R(){let{kind:e,name:t}=this.#e;if(e==="quilt")return;let r=Xe(location.hash),o=r.eye&&r.look&&{eye:r.eye,yaw:r.look[0],pitch:r.look[1]},s=this.#d??o;if(s===void 0)return wr(t);let{fovDeg:i,stereo:a,eyeDistance:c}=this.#c,u={pose:s,fovDeg:i,stereo:a,eyeDistance:c,size:this.#_(1/this.#c.scale)},l=this.#h??r.frame;return wr(t,e==="glb"||l===void 0?u:{...u,frame:l})}#I(){let e=this.#u?.player.film.headBox,t=e===void 0?[0]:e.least.map((r,o)=>e.greatest[o]-r);return Math.min(Math.max(Sl*Math.max(...t),Pi[0]),Pi[1])}#D(e,t){this.#d===void 0||this.#u===void 0||this.#e.kind==="quilt"||(this.#d=fi(this.#d,e,t),this.#u.loop.move())}#H(e){if(this.#d===void 0||this.#u===void 0||this.#e.kind==="quilt")return;let t=li(this.#d.eye,hi(this.#d,e),this.#u.player.film.headBox);this.#d={...this.#d,eye:t},this.#u.loop.move()}#G(e){let t=this.#u;if(this.#e.kind==="quilt"&&t!==void 0&&!t.clock.isPlaying){let{firstFrame:r,frameCount:o}=t.player.film;t.clock.seek(r+e*(o-1),performance.now())}}#C(e){this.#u?.clock.pause(performance.now()),this.#u?.clock.seek(e,performance.now())}#v(e){let t={...this.#c,...e};this.#c=t,this.#i.show(t),this.#a.showMarks(t.marks),this.#g=-1/0;let r=this.#u;r!==void 0&&(r.clock.isLooped=t.isLooped,r.clock.setSpeed(t.speed,performance.now()),r.showOverdraw?.(t.marks.has("overdraw")),r.loop.move()),this.#e.kind==="lfold"&&t.renderer!==this.#b&&this.load()}#z(e,t){let r=[...this.#c.marks].filter(o=>o!==e);this.#v({marks:new Set(t?[...r,e]:r)})}#B(e,{eye:t,look:r}){let o=this.#u?.player.film.headBox;return{eye:t!==void 0&&o!==void 0?qe(t,o):e.eye,yaw:r?.[0]??e.yaw,pitch:r?.[1]??e.pitch}}#$(){let e=Xe(location.hash),t=this.#u;this.#d=t&&this.#B(t.player.film.start,e),this.#h=void 0,t!==void 0&&this.#C(e.frame??t.player.film.firstFrame),this.#v({...L,...e.settings}),this.#u?.loop.move()}#U(e){let t=bi(this.#d??Sr,e,this.#c);t!==location.hash&&history.replaceState(null,"",t)}#L(e){let[t,r]=[this.#u,performance.now()];t!==void 0&&(e==="settings"||e==="inspector"||e==="help"?this.#s.toggle(e):e==="full-screen"?Ol().catch(()=>this.#n.say("The browser allows no full screen here.")):this.#V(t,e,r))}#V({clock:e,player:t,loop:r},o,s){let{film:i}=t;switch(o){case"play":return r.change(),e.isPlaying?e.pause(s):e.play(s);case"step-back":return e.step(-1,s);case"step-forward":return e.step(1,s);case"first":return this.#C(i.firstFrame);case"last":return this.#C(e.lastFrame);case"loop":return this.#v({isLooped:!this.#c.isLooped});case"slower":return this.#v({speed:Ye.findLast(a=>a<this.#c.speed)??Ye[0]});case"faster":return this.#v({speed:Ye.find(a=>a>this.#c.speed)??Ye[Ye.length-1]});case"reset":return this.#d=i.start,r.move();case"lock-pointer":return this.#f.toggleLock();case"screenshot":return this.#k=!0,r.change()}}#W(){["play","step-back","step-forward","first","last","loop","screenshot","full-screen"].forEach(r=>P(r,()=>this.#L(r)));for(let r of["settings","inspector","help"])P(`open-${r}`,()=>this.#L(r));let t=P("copy-link",()=>{this.#u!==void 0&&this.#U(this.#h??0),ae(location.href,t)});P("headset",()=>{this.#u?.enterHeadset?.(this.#d??Sr)?.catch(o=>this.#n.say(`The headset does not open: ${ce(o)}`))})}},Sr={eye:[0,0,0],yaw:0,pitch:0};function Tl(n){document.querySelectorAll("[data-kinds]").forEach(e=>{e.hidden=!(e.dataset.kinds??"").split(" ").includes(n)})}function Cl({kind:n},e){return n==="glb"?e?"The button Headset shows this scene in WebXR.":"This scene plays in WebXR, by a button that appears where the browser finds a headset.":n==="quilt"?"Quilts are for displays of Looking Glass; headsets show other forms of light fields.":"This page does not show light fields in headsets: WebXR takes pictures of WebGL in most browsers, and these are made by WebGPU. lightfold render --projection vr180 --stereo side-by-side makes pictures for headsets; lightfold simplify makes a scene (.glb) of a frame, which this page shows in WebXR."}async function Ol(){await(document.fullscreenElement===null?document.documentElement.requestFullscreen():document.exitFullscreen())}var Ni=()=>location.reload();async function Pl(){try{let n=new URL("film.json",document.baseURI);await new x1(await Lr(n.href),ci).load()}catch(n){new ue(Ni,Ni).failed(n,void 0)}}Pl();
