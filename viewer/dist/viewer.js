function Hi(s){return globalThis.document?.querySelector(`script[data-file="${s}"]`)?.textContent??void 0}function Gi(s){let e=s.endsWith("==")?2:s.endsWith("=")?1:0,t=new Uint8Array(s.length/4*3-e);for(let r=0;r<s.length;r+=1048576){let n=atob(s.slice(r,r+1048576)),o=r/4*3;for(let i=0;i<n.length;i+=1)t[o+i]=n.charCodeAt(i)}return t}function Se(s){let e=Hi(s);return e===void 0?void 0:Gi(e.trim())}var zi={js:"text/javascript",wasm:"application/wasm",jpg:"image/jpeg"},sn=new Map;function Q(s,e){let t=sn.get(s);if(t!==void 0)return t;let r=Se(s);if(r===void 0)return new URL(s,e).href;let n=zi[s.split(".").pop()??""]??"application/octet-stream",o=URL.createObjectURL(new Blob([r],{type:n}));return sn.set(s,o),o}function He(s,e){let t=Q(s,e);return new Worker(t,{type:t.startsWith("blob:")?"classic":"module"})}var g=class extends Error{name="FormatError"},y=class extends Error{name="UnsupportedError"};var Re=class extends Error{name="FileChangedError"},A=class extends Error{constructor(t,r){super(t);this.status=r}status;name="TransportError"},on=16,ze=class s{constructor(e,t,r,n){this.url=e;this.byteCount=t;this.version=r;this.first=n}url;byteCount;version;first;static async open(e,t){let r=await cn(e,{Range:`bytes=0-${on-1}`},t),{range:n,size:o}=ur(r);if(r.status===416&&o===0)return await Ge(r),new s(e,0,cr(r),new Uint8Array(0));if(r.status===200)throw await Ge(r),new y("The server does not answer requests for ranges of a file, which the player needs: nginx and Apache do, python3 -m http.server does not.");try{if(un(r),o===void 0||!n||n[0]!==0||n[1]!==Math.min(on,o)-1)throw new A("The server does not tell the size of the file, or answered with another range",206)}catch(a){throw await Ge(r),a}let i=await ln(r,n[1]+1,t);return new s(e,o,cr(r),i)}async read(e,t,r){let n=e+t-1;if(!(e>=0&&t>=0&&n<this.byteCount))throw new RangeError(`bytes ${e} to ${n} of a file of ${this.byteCount}`);if(n<this.first.length)return this.first.slice(e,e+t);if(t===0)return new Uint8Array(0);let o=an(this.version.etag)?{"If-Range":this.version.etag}:void 0,i=await cn(this.url,{Range:`bytes=${e}-${n}`,...o},r);try{this.checkVersion(i),un(i),this.checkRange(i,e,n)}catch(a){throw await Ge(i),a}return ln(i,t,r)}checkVersion(e){let{status:t}=e;if(t!==200&&t!==206&&t!==412&&t!==416)return;let{etag:r,lastModified:n}=cr(e),{size:o}=ur(e),i=r!==null&&r!==this.version.etag||n!==null&&this.version.lastModified!==null&&n!==this.version.lastModified||o!==void 0&&o!==this.byteCount,a=t===200&&an(this.version.etag)&&r!==this.version.etag;if(i||a||(t===412||t===416))throw new Re("The file on the server has changed since it was opened")}checkRange(e,t,r){let{range:n}=ur(e);if(n?.[0]!==t||n[1]!==r){let o=n?`bytes ${n[0]} to ${n[1]}`:"no range";throw new A(`The server answered with ${o} where bytes ${t} to ${r} were asked for`,206)}}};function an(s){return s!==null&&s.startsWith('"')}function cr({headers:s}){return{etag:s.get("ETag"),lastModified:s.get("Last-Modified")}}function ur({headers:s}){let e=/^bytes (?:(\d{1,15})-(\d{1,15})|\*)\/(?:(\d{1,15})|\*)$/u.exec(s.get("Content-Range")??"");return{range:e?.[1]===void 0?void 0:[Number(e[1]),Number(e[2])],size:e?.[3]===void 0?void 0:Number(e[3])}}async function cn(s,e,t){try{return await fetch(s,{headers:e,cache:"no-store",signal:t??null})}catch{throw dn(t)}}function dn(s){return s?.aborted?s.reason:new A("The connection to the server failed or was cut")}function un({status:s}){if(s!==206)throw new A(`The server answered ${s} where a part of the file was asked for`,s)}async function Ge(s){await s.body?.cancel().catch(()=>{})}async function ln(s,e,t){let r=await lr(s,e).catch(()=>{throw dn(t)});if(r.length!==e){let n=r.length>e?"more":r.length;throw new A(`The server sent ${n} bytes where ${e} were asked for`)}return r}async function lr(s,e){let t=[],r=0,n=s.body?.getReader();for(let a=await n?.read();a&&!a.done;a=await n?.read())if(t.push(a.value),r+=a.value.length,r>e){await n?.cancel().catch(()=>{});break}if(t.length===1)return t[0];let o=new Uint8Array(r),i=0;for(let a of t)o.set(a,i),i+=a.length;return o}function j(s,e){return[s[0]+e[0],s[1]+e[1],s[2]+e[2]]}function Z(s,e){return[s[0]-e[0],s[1]-e[1],s[2]-e[2]]}function N(s,e){return[s[0]*e,s[1]*e,s[2]*e]}function dr(s,e){return s[0]*e[0]+s[1]*e[1]+s[2]*e[2]}function fr(s,e){return[s[1]*e[2]-s[2]*e[1],s[2]*e[0]-s[0]*e[2],s[0]*e[1]-s[1]*e[0]]}function q(s){return Math.sqrt(dr(s,s))}function fn(s,e){return q(Z(s,e))}function We([s,e,t,r]){let n=Math.sqrt(s*s+e*e+t*t+r*r),o=1/n;return Math.abs(n-1)<=.001?[s*o,e*o,t*o,r*o]:void 0}function je([s,e,t,r],n){let o=[s,e,t],i=N(o,2*dr(n,o)),a=N(fr(o,n),2*r);return j(j(N(n,r*r-dr(o,o)),i),a)}function mn([s,e,t,r]){return[-s,-e,-t,r]}var ee=89*Math.PI/180;function mr({yaw:s,pitch:e}){return[-Math.sin(s)*Math.cos(e),Math.sin(e),-Math.cos(s)*Math.cos(e)]}function hn(s,[e,t,r]){let n=Math.atan2(t,Math.hypot(e,r)),o=e===0&&r===0?0:Math.atan2(-e,-r);return{eye:s,yaw:o,pitch:Math.min(Math.max(n,-ee),ee)}}function hr({yaw:s}){return[Math.cos(s),0,-Math.sin(s)]}function pr(s){let e=Math.round(s/(2*Math.PI));return s-e*2*Math.PI}function pn(s,e,t){let r=Math.min(Math.max(s.pitch+t,-ee),ee);return{eye:s.eye,yaw:pr(s.yaw+e),pitch:r}}function bn(s,[e,t,r]){let n=hr(s),o=mr(s);return[e*n[0]+r*o[0],e*n[1]+t+r*o[1],e*n[2]+r*o[2]]}var U={exposureEv:0,toneMap:"none",fovDeg:60,stereo:"mono",eyeDistance:.063,steps:1024,scale:1,speed:1,isLooped:!0,marks:new Set,renderer:"auto"},Wi={exposureEv:[-10,10],fovDeg:[20,120],eyeDistance:[0,.5],steps:[32,4096],scale:[.125,1],speed:[.25,2]},Ve=["none","reinhard","filmic"],$e=["mono","side-by-side","anaglyph"],Ke=["auto","gpu","cpu"],br=["probes","nodes","holes","units","keyframes","fetched","overdraw"];function V(s,e){let[t,r]=Wi[s],n=Math.min(Math.max(e,t),r);return s==="steps"?Math.round(n):n}var S=class extends Error{name="FilmFileError"},ji=["lfold","glb","quilt"],wn=65536,Vi=4096,$i=1024,gn=4096;function gr(s,e){if(typeof s!="object"||s===null||Array.isArray(s))throw new S(`${e}: an object was expected.`);return s}function xn(s,e,t){if(typeof s!="string"||s===""||s.length>t)throw new S(`${e}: a text of 1 to ${t} characters was expected.`);return s}function wr(s,e,[t,r]){if(typeof s!="number"||!Number.isInteger(s)||s<t||s>r)throw new S(`${e}: a whole number of ${t} to ${r} was expected.`);return s}function yn(s,e){if(!(Array.isArray(s)&&s.length===3&&s.every(r=>Number.isFinite(r))))throw new S(`${e}: three numbers were expected.`);return[...s]}function Ki(s){let e=gr(s,"film.json, start"),t=yn(e.eye,"film.json, start.eye"),r=Z(yn(e.look_at,"film.json, start.look_at"),t),n=e.fov_y_deg;if(typeof n!="number"||!(n>0&&n<180))throw new S("film.json, start.fov_y_deg: a number above 0 and below 180 was expected.");if(!(q(r)>0))throw new S("film.json, start.look_at: another point than the eye was expected.");return{pose:hn(t,r),fovDeg:V("fovDeg",n)}}function _n(s,e,t){let r=xn(s,e,Vi),n=new URL(t);if(!(!/^[a-z][a-z0-9+.-]*:/i.test(r)&&!/^\s|[\\\u0000-\u001f]/.test(r)&&!r.startsWith("//"))||!URL.canParse(r,n))throw new S(`${e}: a path relative to the page was expected.`);let i=new URL(r,n);if(i.origin!==n.origin||i.username!==n.username||i.password!==n.password)throw new S(`${e}: the file must come from the page's own server.`);return i.hash="",i.href}function qi(s){let e=gr(s,"film.json, quilt"),t=e.aspect;if(typeof t!="number"||!(t>=.01&&t<=100))throw new S("film.json, quilt.aspect: a number of 0.01 to 100 was expected.");return{columns:wr(e.columns,"film.json, quilt.columns",[1,gn]),rows:wr(e.rows,"film.json, quilt.rows",[1,gn]),aspect:t}}function vn(s,e){let t;try{t=JSON.parse(s)}catch{throw new S("film.json: JSON was expected.")}let r=gr(t,"film.json"),n=ji.find(i=>i===r.kind);if(n===void 0)throw new S("film.json, kind: lfold, glb or quilt was expected.");let o={kind:n,url:_n(r.url,"film.json, url",e),name:xn(r.name,"film.json, name",$i),bytes:wr(r.bytes,"film.json, bytes",[0,Number.MAX_SAFE_INTEGER])};return r.start!==void 0&&(o.start=Ki(r.start)),r.poster!==void 0&&(o.poster=_n(r.poster,"film.json, poster",e)),n==="quilt"?{...o,quilt:qi(r.quilt)}:o}async function kn(s){let e=Se("film.json");if(e!==void 0)return vn(new TextDecoder().decode(e),s);let t=()=>{throw new S("film.json, which names the film, cannot be reached.")},r=await fetch(s,{cache:"no-store"}).catch(t);if(!r.ok)throw new S(`film.json, which names the film: the server answered ${r.status}.`);let n=await lr(r,wn).catch(t);if(n.length>wn)throw new S("film.json is longer than any that names a film.");return vn(new TextDecoder().decode(n),s)}function p(s,e){let t=document.getElementById(s);if(!(t instanceof e))throw new Error(`index.html has no ${e.name} named ${s}`);return t}function H(s,e){let t=p(s,HTMLButtonElement);return t.addEventListener("click",e),t}function M(s,e){s.textContent!==e&&(s.textContent=e)}function qe(s,e){for(;s.rows.length>e.length;)s.deleteRow(-1);e.forEach((t,r)=>{let n=s.rows[r]??s.insertRow();t.forEach((o,i)=>{let a=n.cells[i];a===void 0&&(a=n.appendChild(document.createElement(i===0?"th":"td")),i===0&&(a.scope="row")),M(a,o),a.classList.toggle("number",i>0&&/^[\d-]/.test(o))})})}var Xi=new Intl.NumberFormat("en-US",{maximumFractionDigits:2});function G(s){return Xi.format(s)}function ie(s){let e=["B","kB","MB","GB","TB"],t=s,r=0;for(;t>=999.5&&r<e.length-1;)t/=1e3,r+=1;return`${r===0?t:t.toPrecision(3)} ${e[r]}`}function Xe(s){return`${s.toFixed(1)} ms`}function yr(s){return/[.!?]$/.test(s)?s:`${s}.`}function _r(s){return s.replace(/\.$/,"")}async function Ye(s,e,t){let r=e.querySelector("span")??e,n=e.dataset.text??=r.textContent??"",o="Copied";try{await navigator.clipboard.writeText(s)}catch{o="Press Ctrl+C",t!==void 0?getSelection()?.selectAllChildren(t):o="Copy the address"}r.textContent=o,e.classList.add("says"),setTimeout(()=>{r.textContent=n,e.classList.remove("says")},1500)}function ae(s){return s instanceof Error?s.message:String(s)}var Yi=4,Je=class{#e=p("messages",HTMLElement);#t=new WeakMap;say(e,t=1/0){let r=yr(e),n=[...this.#e.children],o=n.find(c=>c.firstChild?.textContent===r);if(o!==void 0){this.#r(o,t);return}n.slice(0,Math.max(0,n.length-Yi+1)).forEach(c=>c.remove());let i=document.createElement("div");i.className="message",i.appendChild(document.createElement("span")).textContent=r;let a=i.appendChild(document.createElement("button"));a.type="button",a.textContent="Dismiss",a.addEventListener("click",()=>i.remove()),this.#e.appendChild(i),this.#r(i,t)}#r(e,t){clearTimeout(this.#t.get(e)),t!==1/0&&this.#t.set(e,setTimeout(()=>e.remove(),t))}clear(){this.#e.replaceChildren()}},ce=class{#e=p("notice",HTMLElement);#t=p("notice-title",HTMLElement);#r=p("notice-text",HTMLElement);#n;#s=p("stage",HTMLElement);#o=p("tools",HTMLElement);#i=[this.#o,p("side",HTMLElement),p("transport",HTMLElement),p("state",HTMLElement)];constructor(e){this.#n=H("notice-retry",e)}opening(e){this.#a("Opening",e),this.#n.hidden=!0}failed(e){this.#a("The film cannot be shown",yr(ae(e))),this.#n.hidden=!1,this.#e.focus()}hide(){this.#e.hidden=!0,this.#o.hidden=!1,this.#s.inert=!1}#a(e,t){M(this.#t,e),M(this.#r,t),[this.#t,this.#r].forEach(r=>r.classList.remove("unopened")),this.#e.hidden=!1,this.#i.forEach(r=>r.hidden=!0),this.#s.inert=!0}};var Qe=class{constructor(e){this.bytes=e}bytes;get byteCount(){return this.bytes.length}read(e,t){return e<0||t<0||e+t>this.bytes.length?Promise.reject(new g(`The file ends before byte ${e+t}.`)):Promise.resolve(this.bytes.subarray(e,e+t))}};var ue={none:0,reinhard:1,filmic:2},Ze={mono:0,"side-by-side":1,anaglyph:2};var Ji=-1,Qi=-2,et=class extends Error{name="DecoderStopped"},tt=class{#e;#t=!1;constructor({exports:e}){this.#e=e}get isStopped(){return this.#t}get memoryBytes(){return this.#e.memory.buffer.byteLength}write(...e){let t=e.reduce((n,{byteLength:o})=>n+o,0),r=this.run(({input:n})=>n(t))>>>0;for(let{buffer:n,byteOffset:o,byteLength:i}of e)new Uint8Array(this.#e.memory.buffer,r,i).set(new Uint8Array(n,o,i)),r+=i}output(){let[e,t]=this.run(r=>[r.output_pointer()>>>0,r.output_bytes()>>>0]);return new Uint8Array(this.#e.memory.buffer,e,t)}words(){let e=this.output();return new Uint32Array(e.buffer,e.byteOffset,e.length/4)}text(){return new TextDecoder().decode(this.output())}call(e){let t=this.run(e);if(t>=0)return t;let r=this.text(),n=`${r.slice(0,1).toUpperCase()}${r.slice(1)}.`;throw t===Ji?new g(n):t===Qi?new y(n):new Error(n)}run(e){if(this.#t)throw new et("The decoder has stopped.");try{return e(this.#e)}catch(t){throw this.#t=!0,new et(`The decoder has stopped: ${t instanceof Error?t.message:String(t)}.`)}}};function En({eye:s,axes:e,half:t}){return[...s,...e.flat(),...t]}var Zi=["color","depth","material","alpha"],Sn=["raw","lzma2","zstd"],ea=1,Rn=5,ta=9,vr=class extends Error{name="NextIsMissing"},Me=class{#e;constructor(e){this.#e=new tt(e)}get isStopped(){return this.#e.isStopped}get memoryBytes(){return this.#e.memoryBytes}crc32(e){return this.#e.write(e),this.#e.run(t=>t.crc32())>>>0}decompress(e,t,r){return this.#e.write(t),this.#e.call(n=>n.decompress(Sn.indexOf(e),r)),this.#e.output().slice()}openStream(e,t){let{kind:r,codec:n,face:o,width:i,height:a,unitWidth:c,unitHeight:u}=e,l=new Uint8Array(n.length+t.length);l.set(Array.from(n,m=>m.charCodeAt(0))),l.set(t,n.length),this.#e.write(l);let d=[Zi.indexOf(r),o,i,a,c,u];return{number:this.#e.call(m=>m.open_stream(...d)),header:JSON.parse(this.#e.text())}}closeStream({number:e}){this.#e.run(t=>t.close_stream(e))}openChunk({number:e,header:t},r){let n=this.#n(r),o=this.#e.call(i=>i.open_chunk(e,...n));return this.#t(o,t.kind==="depth"||t.kind==="color"&&t.isHalf)}openCodings({number:e},t){let r=this.#n(t);return this.#t(this.#e.call(n=>n.open_codings(e,...r)),!1)}prepare({number:e},t){let r=this.#n(t);this.#e.call(F=>F.prepare(e,...r));let n=this.#e.words(),[o,i,a,c,u]=n,l=Rn+ta,d=Array.from(n.subarray(Rn,l),F=>n.slice(l,l+=F)),[f,m,h,b,w,_,v,x,P]=d;return{kernel:o===1?"keyframes":"codec",isNodes:i===1,stream:f,records:m,boxes:h,weights:[a,c],passes:u,timeline:{recordFrames:b,recordPixels:w,keyframes:_,weights:v,frameSets:x,framePixels:P}}}transformTables(e){let t=Uint32Array.from(e,({number:n})=>n);this.#e.write(t),this.#e.call(n=>n.transform_tables());let r=this.#e.words();return{words:r.slice(e.length),firstSets:[...r.subarray(0,e.length)]}}log2Table(){return this.#e.run(e=>e.log2_table()),this.#e.words().slice()}inverseDepths({nearM:e,farM:t}){return this.#e.call(r=>r.inverse_depths(e,t)),this.#e.words().slice()}visibleUnits(e,t,r,n){let{face:o,width:i,height:a,unitWidth:c,unitHeight:u}=e,{position:l,orientation:d,intrinsics:f}=t;return this.#e.write(Float64Array.of(...l,...d,...f,r,...n.flatMap(En))),this.#e.call(m=>m.visible_units(o,i,a,c,u)),this.#e.output().slice()}straightTexels(e,t,r,n){let o=Float64Array.of(e,...r,...t.rect,...n?.rect??[0,0,0,0]);return this.#e.write(o,t.pixels,...n===void 0?[]:[n.pixels]),this.#e.call(i=>i.straight_texels()),this.#e.output().slice()}raySteps(e,t,r,n){this.#e.run(i=>i.ray_steps(e,t,r,n));let o=new Float32Array(this.#e.words().slice().buffer);return{logStep:o[0],uncertainty:o[1],distancesM:o.slice(2)}}presentPictures(e,t){let{exposureEv:r,overlayShare:n,toneMap:o,marksHoles:i,isAnaglyph:a}=t;this.#e.write(Float64Array.of(r,n,e[0].length/4),...e);let c=ue[o];return this.#e.call(u=>u.present_pictures(c,Number(i),Number(a))),new Uint8ClampedArray(this.#e.output())}#t(e,t){return{frame:(r,n)=>{this.#e.call(i=>i.show_frame(e,r))===ea&&(this.#r(e,n?.()),this.#e.call(i=>i.show_frame(e,r)));let o=this.#e.output();return t?new Uint16Array(o.buffer,o.byteOffset,o.length/2):o},close:()=>this.#e.run(r=>r.close_chunk(e))}}#r(e,t){if(t===void 0)throw new vr("A frame blends into the next chunk of its cell, which is not there (color.md 4).");let[,...r]=this.#n(t);this.#e.call(n=>n.set_next(e,...r))}#n({chunk:e,stored:t,area:r}){if(t.length!==e.storedBytes||this.crc32(t)!==e.crc32){let o=e.firstFrame+e.frameCount-1;throw new g(`The CRC-32 of stream ${e.stream}, unit ${e.unit}, frames ${e.firstFrame} to ${o} does not match: the file is damaged at byte ${e.offset} (container.md 6).`)}let n=r.place==="last"?1:0;return[e.unit,e.frameCount,n,Sn.indexOf(e.storage),e.rawBytes]}};var nt,rt;async function Mn(){nt??=await ra(Q("lightfold.wasm",import.meta.url)),(rt===void 0||rt.isStopped)&&(rt=new Me(await WebAssembly.instantiate(nt)))}async function ra(s){let e=await fetch(s).catch(t=>{throw new A(`The decoder cannot be loaded: ${t instanceof Error?t.message:String(t)}.`)});if(!e.ok)throw new A(`The decoder cannot be loaded: the server answered with status ${e.status}.`);return WebAssembly.compile(await e.arrayBuffer())}function Te(){if(nt===void 0)throw new Error("The decoder is not loaded.");return nt}function na(){return new Me(new WebAssembly.Instance(Te()))}function k(){return rt??=na()}var st=class{bytes;#e;#t;at=0;constructor(e,t){this.bytes=e,this.#e=new DataView(e.buffer,e.byteOffset,e.byteLength),this.#t=t}get remaining(){return this.bytes.length-this.at}error(e){return new g(`${e}, at offset ${this.at} (${this.#t}).`)}skip(e){let t=this.at;if(!(e<=this.remaining))throw this.error(`${e} more bytes were expected where ${this.remaining} are left`);return this.at+=e,t}u8(){return this.bytes[this.skip(1)]}u16(){return this.#e.getUint16(this.skip(2),!0)}u32(){return this.#e.getUint32(this.skip(4),!0)}f32(){return this.#e.getFloat32(this.skip(4),!0)}f64(){return this.#e.getFloat64(this.skip(8),!0)}zeros(e){let t=this.skip(e);if(this.bytes.subarray(t,t+e).some(r=>r!==0))throw this.error("A reserved byte is not 0")}varint(){let e=0;for(let t=0;t<5;t+=1){let r=this.u8();if(e+=(r&127)*2**(7*t),r===0&&t>0)throw this.error("A number is not in its shortest form");if(r<128)return e}throw this.error("A number has more than five bytes")}finish(){if(this.remaining>0)throw this.error(`${this.remaining} bytes are left behind the last field`)}};var sa=/[\u0000-\u001f\u007f-\u009f]/u,$=class extends st{section;#e;#t;constructor(e,t,r){super(e,t),this.section=t,this.#e=r,this.#t=new DataView(e.buffer,e.byteOffset,e.byteLength)}error(e,t=this.at){return new g(`${e}, at byte ${this.#e+t} (${this.section}).`)}take(e){let t=this.skip(e);return this.bytes.subarray(t,t+e)}u64(e){let t=this.skip(8),r=this.#t.getUint32(t,!0)+this.#t.getUint32(t+4,!0)*2**32;if(!Number.isSafeInteger(r))throw this.error(`${e} is larger than any file`,t);return r}finites(e,t){return Array.from({length:e},()=>{let r=this.at,n=this.f64();if(!Number.isFinite(n))throw this.error(`${t} is ${n}, where a finite number was expected`,r);return n})}varint32(){let e=this.at,t=this.varint();if(t>=2**32)throw this.error(`${t} is more than 32 bits hold`,e);return t}string(e){let t=this.take(this.u16());try{return new TextDecoder("utf-8",{fatal:!0,ignoreBOM:!0}).decode(t)}catch{throw this.error(`${e} is not UTF-8`,this.at-t.length)}}fits(e,t,r){if(e*r>this.remaining)throw this.error(`${e} ${t} do not fit into the rest of the index`)}};function Tn(s){return sa.test(s)}function le(s){let t=Array.from(s.slice(0,80)).slice(0,40);return`"${t.map(n=>/^[ -~]$/u.test(n)?n:`\\u{${(n.codePointAt(0)??0).toString(16)}}`).join("")}${t.join("").length<s.length?"...":""}"`}var X=16,An=16384,Ae=2**31,oa=2**30,Pn=2**22,ia={raw:1,lzma2:16384,zstd:32768},Cn=["raw","lzma2","zstd"],xr=/^[A-Za-z0-9_-][A-Za-z0-9._-]*$/u;function Nn(s){return Math.ceil(s.width/s.unitWidth)}function L(s){return Nn(s)*Math.ceil(s.height/s.unitHeight)}function R(s,e){let t=Nn(s),r=e%t*s.unitWidth,n=Math.floor(e/t)*s.unitHeight;return[r,n,Math.min(s.unitWidth,s.width-r),Math.min(s.unitHeight,s.height-n)]}function On(s){let e=s.u8();if(s.zeros(3),e>1)throw s.error(`Projection ${e} is unknown`);let[t]=s.finites(1,"The frame rate");if(t<=0)throw s.error(`A frame rate of ${t} is not positive`);let r=s.at,n=s.string("The dataset's name");if(Tn(n))throw s.error("The dataset's name holds control characters",r);return{projection:e,fps:t,name:n}}function de(s,e){return s.finites(3,e)}function ot(s,e){return s.finites(4,e)}function Fn(s,e,{name:t,frames:[r,n]}){if(!xr.test(t))throw s.error(`The probe name ${le(t)} has other than letters, digits, ".", "_" and "-"`,e);if(r>n||n>=Ae)throw s.error(`A probe is active from frame ${r} to ${n}`,e)}function Un(s,e,t,r){let{kind:n,face:o,probe:i,width:a,height:c,unitWidth:u,unitHeight:l,firstFrame:d,frameCount:f}=t;if(n>3||o>6)throw s.error(`A stream has kind ${n} and face ${o}, which is unknown`,e);if(i>=r)throw s.error(`A stream is of probe ${i}, where the file has ${r}`,e);if([a,c,u,l].some(m=>m<1||m>An)){let m=`${a}x${c} pixels in units of ${u}x${l}`;throw s.error(`A stream has ${m}, where each size is 1 to ${An}`,e)}if(f<1||d+f>Ae)throw s.error(`A stream has ${f} frames from frame ${d} on, which is impossible`,e)}function Ln(s,e,t,r){let{offset:n,storedBytes:o,rawBytes:i,storage:a}=t;if(n<X||n+o>r)throw s.error(`A chunk of ${o} bytes at byte ${n} lies outside the file's chunks`,e);let c=Math.min(oa,o*ia[a]);if(i>c||a==="raw"&&i!==o)throw s.error(`A chunk of ${o} stored bytes cannot mean ${i} bytes`,e)}function In(s,e,t){if(s.fits(e,"chunks",t),e>Pn)throw new y(`The container has ${e} chunks; this player reads at most ${Pn}.`)}function Bn(s,e){let t=new Set;for(let{name:n}of s){if(t.has(n))throw new g(`Two probes are named ${le(n)} (container.md 4).`);t.add(n)}let r=new Set;e.forEach(({kind:n,probe:o,face:i},a)=>{let c=(o*4+n)*7+i;if(r.has(c))throw new g(`Stream ${a} has the kind, probe and face of an earlier one (container.md 5).`);r.add(c)})}function kr(s,e){let t=new Uint32Array(s.length+1),r=0;if(s.forEach((n,o)=>{if(r+=L(n),r>e)throw new g(`The chunk table breaks off: the streams have more units than its ${e} rows (container.md 6).`);t[o+1]=r}),r===0&&e>0)throw new g(`The index has ${e} chunks and no stream (container.md 6).`);return t}function Dn(s,e){let t=kr(s,e.length),r=new Uint32Array(t[s.length]+1),n=0,o=(i,a,c)=>new g(`The chunk table breaks off at stream ${i}, unit ${a}, frame ${c}: chunks must cover the frames of each unit in order (container.md 6).`);if(s.forEach(({firstFrame:i,frameCount:a},c)=>{let u=i+a;for(let l=0;l<t[c+1]-t[c];l+=1){for(let d=i;d<u;n+=1){let f=e.at(n),m=f?.stream===c&&f.unit===l&&f.firstFrame===d;if(!f||!m||f.frameCount<1||d+f.frameCount>u)throw o(c,l,d);d+=f.frameCount}r[t[c]+l+1]=n}}),n<e.length){let{stream:i,unit:a,firstFrame:c}=e[n];throw o(i,a,c)}return{firstUnits:t,firstChunks:r}}var aa=/^[a-z0-9_.]{1,64}$/u,ca=2**32-1,ua=[.64,.33,.3,.6,.15,.06,.3127,.329],la=1e-9,Pe=["color","depth","material","alpha"];function Gn(s){s.section="container.md 6.3";let e=new Map,t="";for(;s.remaining>0;){let r=s.at,n=s.string("An attribute's name");if(!aa.test(n))throw s.error(`${le(n)} is no name of an attribute`,r);if(n<=t)throw s.error(`The attribute ${n} does not ascend by name`,r);t=n,e.set(n,s.take(s.varint32()))}return e}function zn(s){let e={chromaticities:ua,clippedPixels:void 0,missingFrames:[],poses:new Map,view:void 0},t=c=>{let u=s.get(c);return u&&new $(u,`container.md 6.5, ${c}`,0)},r=t("color.chromaticities");r&&(e.chromaticities=da(r));let n=t("color.clipped_pixels");n&&(e.clippedPixels=n.u32()+n.u32()*2**32,n.finish());let o=t("frames.missing");for(;o&&o.remaining>0;)e.missingFrames.push(fa(o,e.missingFrames.at(-1)));let i=t("probes.poses");i&&(e.poses=ma(i));let a=t("view");return a&&(e.view=ha(a)),e}function da(s){let e=Array.from({length:8},()=>s.f32());s.finish();let[t,r,n,o]=[0,2,4,6].map(l=>{let[d,f]=[e[l],e[l+1]];return[d/f,1,(1-d-f)/f]}),i=[t,r,n,o].flat().every(l=>Number.isFinite(l)),a=it(t,r,n),u=[it(o,r,n),it(t,o,n),it(t,r,o)].every(l=>Number.isFinite(l/a)&&l!==0);if(!i||!(Math.abs(a)>=la)||!u)throw new g(`The chromaticities ${e.join(", ")} span no colors (${s.section}).`);return e}function it(s,e,t){return s[0]*(e[1]*t[2]-e[2]*t[1])+s[1]*(e[2]*t[0]-e[0]*t[2])+s[2]*(e[0]*t[1]-e[1]*t[0])}function Wn(s){let e=s.at,t=s.string("A probe's name");if(!xr.test(t))throw s.error(`${le(t)} is no name of a probe`,e);return t}function Er(s,e,t){if(t>=Ae)throw s.error(`A row names frame ${t}, frames are numbered below ${Ae}`,e)}function fa(s,e){let t=s.at,r=Wn(s),[n,o,i,a]=[s.u8(),s.u8(),s.u32(),s.u32()];if(n>=Pe.length||o>6)throw s.error(`A missing frame is of kind ${n} and face ${o}, which is unknown`,t);let c={probe:r,kind:Pe[n],face:o,frame:i,held:a===ca?void 0:a};if(Er(s,t,i),Er(s,t,c.held??0),e&&!jn(Hn(e),Hn(c)))throw s.error("Rows of missing frames do not ascend",t);return c}function Hn({probe:s,kind:e,face:t,frame:r}){return[s,Pe.indexOf(e),t,r]}function jn(s,e){let t=s.findIndex((r,n)=>r!==e[n]);return t>=0&&s[t]<e[t]}function ma(s){let e=new Map,t;for(;s.remaining>0;){let r=s.at,n=Wn(s),o=s.u32();Er(s,r,o);let i=de(s,"A position"),a=ot(s,"An orientation");if(t&&!jn(t,[n,o]))throw s.error("Rows of poses do not ascend by probe and frame",r);t=[n,o];let c=e.get(n);c?c.push({frame:o,position:i,orientation:a}):e.set(n,[{frame:o,position:i,orientation:a}])}return e}function ha(s){let e=de(s,"An eye"),t=de(s,"A point"),r=s.f64();if(s.finish(),e.join()===t.join())throw new g(`The view looks at its own eye (${s.section}).`);if(!(r>0&&r<180))throw new g(`The view has a field of view of ${r} degrees (${s.section}).`);return{eye:e,lookAt:t,fovDeg:r}}var K=40,Ce=[1,0],Sr=[137,76,70,76,68,13,10,26],pa=[76,70,78,68],ba="container.md 7";function Vn(s){let e=new $(s,"container.md 3",0),t=e.take(Math.min(Sr.length,s.length));if(t.length<Sr.length||Sr.some((o,i)=>t[i]!==o))throw new g("This is not a lightfold container: its first 8 bytes are other (container.md 3).");let[r,n]=[e.u16(),e.u16()];if(r!==Ce[0])throw new y(`The container has format version ${r}; this player reads version ${Ce[0]}.`);return e.zeros(4),n}function Rr(s,e){let t=e-K;if(!Kn(s))throw new g("The container has no foot: it was cut short, so copy or encode it again (container.md 7).");let r=new $(s,ba,t);if(k().crc32(s.subarray(0,32))!==new DataView(s.buffer,s.byteOffset).getUint32(32,!0))throw r.error("The foot's CRC-32 does not match: the file is damaged");let[n,o]=[r.u64("The index's offset"),r.u64("The index")],i=r.u32();r.zeros(4);let a=r.u64("The file's size");if(a!==e)throw r.error(`The foot speaks of a file of ${a} bytes, this one has ${e}`,24);if(n<X||n+o!==t)throw r.error("The index does not lie between the chunks and the foot",0);return{indexOffset:n,indexBytes:o,indexCrc32:i}}function $n(s,e){let t=e-s.length;for(let r=s.length-1;r>=K;r-=1){let n=s.subarray(r-K,r);if(Kn(n)&&wa(n,t+r))return t+r}}function Kn(s){return s.length===K&&pa.every((e,t)=>s[K-4+t]===e)}function wa(s,e){try{return Rr(s,e),!0}catch{return!1}}var ga=27,ya=2,_a=1,va=2**16,xa=1,ka=2,Ea=4,Sa=1,Ra=2,Ma=4,Ta=8,Aa=16,Pa=32,Ca=64,Na=128,qn=3,Oa=4,Fa={name:"",position:[0,0,0],orientation:[0,0,0,1],frames:[0,0],intrinsics:[0,0,0,0]},Ua={kind:0,face:-1,probe:0,codec:"\0\0\0\0",width:0,height:0,firstFrame:0,frameCount:0,unitWidth:0,unitHeight:0,headerBytes:new Uint8Array(0),chunkFrames:0};function Xn(s,e){let t=new $(s,"container.md 4",e),[r,n,o]=[t.varint32(),t.varint32(),t.varint32()],i=t.u8();if(i>1)throw t.error(`Order ${i} of the chunk table is unknown`);let a=On(t);t.fits(r,"probes",ga);let c=[];for(let f=0;f<r;f+=1)c.push(La(t,c.at(-1)??Fa));t.section="container.md 5",t.fits(n,"streams",ya);let u=[];for(let f=0;f<n;f+=1)u.push(Ia(t,u,r));t.section="container.md 6",In(t,o,_a);let l=new Mr(t,u,o).read(i===1,e),d=Gn(t);return Bn(c,u),{...a,probes:c,streams:u,chunks:l,units:Dn(u,l),attributes:d}}function La(s,e){let t=s.at,r=s.u8();if(r>7)throw s.error(`A probe has flags ${r}, of which some are unknown`,t);let n=s.string("A probe's name"),o={...e,name:n,position:de(s,"A probe's position")};return r&xa&&(o.orientation=ot(s,"A probe's orientation")),r&ka&&(o.frames=[s.varint32(),s.varint32()]),r&Ea&&(o.intrinsics=s.finites(4,"A probe's intrinsics")),Fn(s,t,o),o}function Ia(s,e,t){let r=s.at,n=s.u8(),o={...e.at(-1)??Ua};if(o.face+=1,n&Sa&&(o.kind=s.u8(),o.codec=String.fromCharCode(...s.take(4))),n&Ra&&(o.probe=s.varint32()),n&Ma&&(o.face=s.u8()),n&Ta&&([o.width,o.height]=[s.varint32(),s.varint32()]),n&Aa&&([o.firstFrame,o.frameCount]=[s.varint32(),s.varint32()]),n&Pa&&([o.unitWidth,o.unitHeight]=[s.varint32(),s.varint32()]),n&Ca){let i=s.varint32();if(i>e.length)throw s.error(`A codec header is that of ${i} rows before, where there are ${e.length}`,r);o.headerBytes=i>0?e[e.length-i].headerBytes:s.take(s.varint32())}return n&Na&&(o.chunkFrames=s.varint32()),Un(s,r,o,Math.min(t,va)),o}var Mr=class{constructor(e,t,r){this.fields=e;this.streams=t;this.count=r;this.firstUnits=kr(t,r);let n=this.firstUnits[t.length];[this.streamOf,this.nextFrame]=[new Uint32Array(n),new Uint32Array(n)],t.forEach(({firstFrame:o},i)=>{let[a,c]=[this.firstUnits[i],this.firstUnits[i+1]];this.streamOf.fill(i,a,c),this.nextFrame.fill(o,a,c)})}fields;streams;count;firstUnits;streamOf;nextFrame;rows=[];read(e,t){let{fields:r,rows:n}=this,o=this.nextFrame.length,i=0,a=X;for(let c=0;c<this.count;c+=1){let u=r.at,l=r.varint(),d=l%8,f=0;if(d&Oa&&(f=r.varint32(),f<1||f>=o))throw r.error(`A step of ${f} units, where there are ${o}`,u);let m=(i+f)%o,h=this.frames(m,u),b=(d&3)===qn;this.place(h,[d&3,Math.floor(l/8)],[u,a]),Ln(r,u,h,t),a+=b?0:h.storedBytes,n.push(h);let{firstFrame:w,frameCount:_}=this.streams[h.stream],v=this.nextFrame[m]===w+_;i=e&&!v?m:(m+1)%o}if(a!==t)throw r.error(`The chunks end at byte ${a}, and the index starts at ${t}`);return this.sorted()}frames(e,t){let r=this.streamOf[e],n=this.streams[r],o=this.nextFrame[e],i=n.firstFrame+n.frameCount-o,a=n.chunkFrames===0?this.fields.varint32():Math.min(n.chunkFrames,i);if(a<1||a>i)throw this.fields.error(`A chunk has ${a} frames of a unit of which ${i} are left`,t);return this.nextFrame[e]+=a,{...{stream:r,unit:e-this.firstUnits[r],firstFrame:o,frameCount:a},offset:0,storedBytes:0,rawBytes:0,crc32:0,storage:"raw"}}place(e,[t,r],[n,o]){let{fields:i,rows:a}=this;if(t===qn){let c=a.at(-1-r);if(!c)throw i.error(`A chunk has the bytes of ${r+1} rows before, where there are ${a.length}`,n);let{offset:u,storedBytes:l,rawBytes:d,crc32:f,storage:m}=c;Object.assign(e,{offset:u,storedBytes:l,rawBytes:d,crc32:f,storage:m});return}e.offset=o,e.storage=Cn[t],e.storedBytes=r,e.rawBytes=t===0?r:i.varint32(),e.crc32=i.u32()}sorted(){let e=new Uint32Array(this.nextFrame.length+1),t=n=>this.firstUnits[n.stream]+n.unit;this.rows.forEach(n=>e[t(n)+1]+=1);for(let n=1;n<e.length;n+=1)e[n]+=e[n-1];let r=Array(this.rows.length);for(let n of this.rows){let o=t(n);r[e[o]]=n,e[o]+=1}return r}};var Ba=2**30,Da=1024,Ha=4,Ga=2**26,za=1024,Wa=2**38,ja=2**20,Tr=2**26,Ar=2**24,Va=4096,at=32,$a=4,Ka=4*2**20;function Yn(s,e,t){let r=Math.max(Ba,Da*t),[n,o,i]=[0,0,0];if(s.streams.forEach((a,c)=>{let u=qa(s,c,e[c]);if(u>r)throw new y(`Stream ${c} of ${a.width}x${a.height} pixels would take ${u} bytes to decode, more than a file of ${t} bytes justifies (container.md 2).`);n+=u,o+=L(a)*a.frameCount,i+=a.width*a.height*a.frameCount}),n>Ha*r)throw new y(`The streams would take ${n} bytes to decode, more than a file of ${t} bytes justifies (container.md 2).`);if(o>Ga+za*t||i>Wa+ja*t)throw new y(`The streams have ${o} units and ${i} pixels in all their frames, more than a file of ${t} bytes justifies (container.md 2).`)}function qa({streams:s,chunks:e,units:t},r,n){let o=s[r],i=o.width*o.height*Xa(n)+L(o)*Va;for(let a=t.firstUnits[r];a<t.firstUnits[r+1];a+=1){let c=0;for(let u=t.firstChunks[a];u<t.firstChunks[a+1];u+=1)c=Math.max(c,Ya(o,e[u],n));i+=c}return i}function Xa(s){switch(s.kind){case"depth":return s.coding.name==="predictive"?32:4;case"material":return 6;case"alpha":return 32;case"color":return s.isHalf?30:12}}function Ya(s,{unit:e,frameCount:t,rawBytes:r},n){if(n.kind==="depth"&&n.coding.name==="nodes")return 64*r;if(n.kind!=="color")return 10*r;let o=4*r+Math.min(8*r,Ka);if(n.coding.name==="cells")return o;let[,,i,a]=R(s,e),[c,u]=Ja(i,a),l=u*t,d=Math.min(832*r+5632*c,72*l);return Math.max(o,d+r+640*c+l)}function Ja(s,e){let t=o=>[[Math.floor(o/at),at],[o%at>0?1:0,o%at]],[r,n]=[0,0];for(let[o,i]of t(s))for(let[a,c]of t(e)){let u=$a;for(;u<Math.max(i,c);)u*=2;r+=o*a,n+=o*a*u*u}return[r,n]}var Qa=65536,ut=class s{constructor(e,t,r,n){this.source=e;this.minorVersion=t;this.indexBytes=r;this.name=n.name,this.fps=n.fps,this.projection=n.projection===0?"cube":"perspective",this.probes=n.probes,this.chunks=n.chunks,this.units=n.units,this.attributes=n.attributes;let o=tc(n.streams);Yn(n,o,e.byteCount),this.streams=n.streams.map((i,a)=>nc(i,a,o[a])),this.footage=zn(n.attributes)}source;minorVersion;indexBytes;name;fps;projection;probes;streams;chunks;attributes;footage;units;static async open(e,t){let r=e.read(0,Math.min(X,e.byteCount),t);await Promise.all([r,Mn()]);let n=Vn(await r);if(e.byteCount<X+K)throw new g(`The container ends after its head, at byte ${e.byteCount} (container.md 7).`);let o=await Za(e,t);if(o.indexBytes>Tr)throw new y(`The container has an index of ${o.indexBytes} bytes; this player reads at most ${Tr}.`);let i=await e.read(o.indexOffset,o.indexBytes,t);if(k().crc32(i)!==o.indexCrc32)throw new g(`The index's CRC-32 does not match: the file is damaged at byte ${o.indexOffset} (container.md 4).`);try{return new s(e,n,o.indexBytes,Xn(i,o.indexOffset))}catch(a){throw n>Ce[1]?ec(a,n):a}}probeAt(e,t){let r=this.probes[e],n=this.footage.poses.get(r.name)??[],o=n[ct(0,n.length,i=>n[i].frame>=t)];return o?.frame===t?{...r,position:o.position,orientation:o.orientation}:r}unitCount(e){return L(this.streams[e])}unitRect(e,t){return R(this.streams[e],t)}chunksOf(e,t){let r=this.units.firstUnits[e]+t;return[this.units.firstChunks[r],this.units.firstChunks[r+1]]}chunkIndex(e,t,r){let[n,o]=this.chunksOf(e,t),i=ct(n,o,c=>this.chunks[c].firstFrame>r)-1;return i>=n&&r<this.chunks[i].firstFrame+this.chunks[i].frameCount?i:-1}chunksAmong(e,t,[r,n]){let[o,i]=this.chunksOf(e,t),a=ct(o,i,c=>this.chunks[c].firstFrame+this.chunks[c].frameCount>r);return[a,ct(a,i,c=>this.chunks[c].firstFrame>n)]}placeOf(e){let{stream:t,unit:r}=this.chunks[e];return e+1===this.chunksOf(t,r)[1]?"last":"inner"}areaOf(e){let{stream:t,unit:r}=this.chunks[e];return{rect:this.unitRect(t,r),place:this.placeOf(e)}}};function ct(s,e,t){let[r,n]=[s,e];for(;r<n;){let o=Math.floor((r+n)/2);t(o)?n=o:r=o+1}return r}async function Za(s,e){let{byteCount:t}=s,r=await s.read(t-K,K,e);try{return Rr(r,t)}catch(n){let o=Math.min(t,Qa),i=$n(await s.read(t-o,o,e),t);throw i===void 0?n:new g(`The container ends at byte ${i}, and ${t-i} bytes follow it (container.md 7).`)}}function ec(s,e){let t=`The format version ${Ce[0]}.${e} is later than this player knows`;return s instanceof y||s instanceof g?new y(`${t}: ${s.message}`):s}function tc(s){let e=new Map,t=0;return s.map((r,n)=>{let{kind:o,codec:i,face:a,width:c,height:u,unitWidth:l,unitHeight:d,headerBytes:f}=r,m={kind:Pe[o],codec:i,face:a,width:c,height:u,unitWidth:l,unitHeight:d},h=Object.values(m).join(),b=e.get(f)??new Map;e.set(f,b);let w=b.get(h);if(w)return w;if(t+=f.length,t>Ar)throw new y(`The streams have more than ${Ar} bytes of different codec headers.`);let _=rc(m,n,f);return b.set(h,_),_})}function rc(s,e,t){try{let r=k().openStream(s,t);return k().closeStream(r),r.header}catch(r){throw(r instanceof g||r instanceof y)&&(r.message=`Stream ${e}: ${r.message}`),r}}function nc(s,e,t){let{face:r,probe:n,codec:o,width:i,height:a,firstFrame:c,frameCount:u,unitWidth:l,unitHeight:d,headerBytes:f}=s;return{...{index:e,kind:t.kind,face:r,probe:n,codec:o,width:i,height:a,firstFrame:c,frameCount:u},unitWidth:l,unitHeight:d,header:t,headerBytes:f}}var Ne={constants:{NONE:4294967295,WORKGROUP:64,DEPTH_BITS_LEFT_OUT:10,SUM_WORKGROUP:256,MAX_GROUPS:65535,NODE_HEADER_WORDS:12,LEVELS:9,BOX_VALUES:0,BOX_CONSTANT:1,BOX_BLOCKS:2,KEYFRAME_SAMPLES:0,KEYFRAME_BLOCKS:1,DOMAIN_LOG:0,DOMAIN_LINEAR:1,DOMAIN_INVERSE:2,CONTEXT_NODE:0,CONTEXT_PLANES:40,CONTEXT_CODED:364,CONTEXT_LAST:460,CONTEXT_LAST_BITS:844,CONTEXT_LEVELS:866,CONTEXT_PALETTE_SIZE:2162,CONTEXT_PALETTE_COLOR:2166,CONTEXT_ROW:2167,CONTEXT_PIXEL:2169,CONTEXT_LATER_FRAME:2185,CONTEXT_LATER_ROW:2187,CONTEXT_LATER_PIXEL:2189,SUM_CLASSES_AT:97,SCAN_AT:109,CLUSTERS_AT:1469,OCTAVE_AT:3674,ROOTS_AT:3690,OFFSETS_AT:3699,SCRATCH_WORDS:4848,PASS_ITERATIONS:5e3,STEP_ITERATIONS:12,SLICE_WORKGROUP:256,SLICE_COLUMNS:1024,RUN_JOINS:65536,RUN_FIRST:131072,RUN_LENGTH_BITS:18,WINNER_AFTER:256,WINNER_BEFORE:512,WINNER_OWN:1024,LIGHT_GLOSS:1,LIGHT_TRACED:2,SHOWN_HOLE:1,SHOWN_OPTICAL:2,SHOWN_GLOSS:3,EROSION_REACH:2,EROSION_TOLERANCE:256,MOVE_BITS:8},structs:[{name:"Unit",members:["picture: u32","width: u32","height: u32","stride: u32","window: u32","domain: u32","base: u32","scale: u32"]},{name:"Chunk",members:["first_record: u32","record_count: u32","weights_at: u32","weight_count: u32"]},{name:"Record",members:["frame: u32","at: u32","first: u32","count: u32","work: u32","coding: u32"]},{name:"BoxRow",members:["x: u32","y: u32","width: u32","height: u32","at: u32","coding: u32","end: u32"]},{name:"Item",members:["unit: u32","chunk: u32","next: u32","frame: u32","key: u32"]},{name:"State",members:["key: u32","frame: u32","weight: u32"]},{name:"Job",members:["unit: u32","end: u32","record: u32","next: u32","weight: u32"]},{name:"Dispatch",members:["x: u32","y: u32","z: u32","part_x: u32","part_y: u32","part_z: u32"]},{name:"DepthJob",members:["picture: u32","stride: u32","left: u32","top: u32","width: u32","table: u32","ray_length: u32","ray_length_pitch: u32","output: u32","pitch: u32","end: u32"]},{name:"PyramidJob",members:["below: u32","below_pitch: u32","below_width: u32","below_height: u32","left: u32","top: u32","width: u32","output: u32","pitch: u32","limit: u32","end: u32"]},{name:"Scene",members:["forward: vec3<f32>","width: u32","right: vec3<f32>","height: u32","down: vec3<f32>","first_row: u32","samples: u32","view_count: u32","distance_count: u32","refine: u32","tolerance: f32","holes: u32","coding: u32","gain: f32","max_bounces: u32","rows: u32","pyramid_rows: u32","longest_segment: u32","first_segment: u32","proxy_count: u32","near_m: f32","far_m: f32","middle: vec2<f32>","log_step: f32","nearest_view: u32","refinements: u32","background: u32","spare: vec2<f32>"]},{name:"DrawnPicture",members:["right: vec3<f32>","scale_x: f32","down: vec3<f32>","shift_x: f32","forward: vec3<f32>","scale_y: f32","eye: vec3<f32>","shift_y: f32","eye_rest: vec3<f32>","nearest_m: f32","near_m: f32","far_m: f32","threshold: f32","spare: u32"]},{name:"View",members:["from_eye: vec3<f32>","near_m: f32","turn_x: vec3<f32>","camera_weight: f32","turn_y: vec3<f32>","greatest_inverse_depth: f32","turn_z: vec3<f32>","reach_m: f32","faces: array<u32, 8>"]},{name:"Face",members:["column: u32","row: u32","layer: u32","has_material: u32","width: u32","height: u32","pyramid_column: u32","pyramid_row: u32","levels: u32","number: u32","scale: vec2<f32>","centre: vec2<f32>","has_alpha: u32","spare: u32"]},{name:"SliceBlock",members:["width: u32","rows: u32","views: u32","spare: u32"]},{name:"SliceRun",members:["column: i32","disparity: i32","first: u32","flags: u32"]},{name:"SlicePlace",members:["place: i32","bias: u32"]},{name:"LineLight",members:["steady_rg: u32","steady_b: u32","own_rg: u32","own_b: u32"]},{name:"LineSplit",members:["light: vec3<f32>","place: f32"]},{name:"PixelRows",members:["width: u32","rows: u32","stride: u32","spare: u32"]}],kernels:[{name:"nodes",about:"Nodes of the quadtree: `DQPN`, `DQTR` and `DB4W`.",entry:"decode_nodes",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/product.wgsl","depth/domain.wgsl","depth/biquadratic.wgsl","depth/platelet.wgsl","depth/bc4w.wgsl","depth/runtime.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","log2_table: read-only-storage","pictures: storage"]},{name:"boxes-codes",about:"Boxes of depth codes: `DAAB`.",entry:"decode_codes",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","depth/records.wgsl","depth/boxes_of_values.wgsl","depth/texel_codes.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"boxes-material",about:"Boxes of material: `MAAB`.",entry:"decode_material",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","depth/records.wgsl","depth/boxes_of_values.wgsl","depth/texel_material.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"cells-8bit",about:"Cells of 8-bit colour: `CCL8`.",entry:"decode_cells",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/samples_8.wgsl","color/cells_of_samples.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"cells-half",about:"Cells of half floats: `CCLH`.",entry:"decode_cells",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/halves.wgsl","color/samples_half.wgsl","color/cells_of_samples.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"boxes-bc5",about:"Boxes of depth codes, block tiles in BC5: `DAB5`.",entry:"decode_codes",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","depth/records.wgsl","depth/block_tiles.wgsl","block/bc4.wgsl","block/bc5.wgsl","depth/block_tiles_bc5.wgsl","depth/texel_codes.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"boxes-bc1",about:"Boxes of material, block tiles in BC1: `MAB1`.",entry:"decode_material",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","depth/records.wgsl","depth/block_tiles.wgsl","block/bc1.wgsl","depth/block_tiles_bc1.wgsl","depth/texel_material.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"cells-bc1",about:"Cells of 8-bit colour with keyframes in BC1: `CCB1`.",entry:"decode_blocks",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","block/bc1.wgsl","color/samples_8.wgsl","color/keyframes_bc1.wgsl","color/cells_of_blocks.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"cells-bc7",about:"Cells of 8-bit colour with keyframes in BC7: `CCB7`.",entry:"decode_blocks",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","block/bptc.wgsl","block/bc7.wgsl","color/samples_8.wgsl","color/keyframes_bc7.wgsl","color/cells_of_blocks.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"cells-bc6h",about:"Cells of half floats with keyframes in BC6H: `CCB6`.",entry:"decode_blocks",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","block/bptc.wgsl","block/bc6h.wgsl","color/halves.wgsl","color/samples_half.wgsl","color/keyframes_bc6h.wgsl","color/cells_of_blocks.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","stream: read-only-storage","pictures: storage"]},{name:"transform-read-8bit",about:"Reads the regions of `CTR8`, an invocation each.",entry:"read_regions",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/samples_8.wgsl","color/transform/domain_bytes.wgsl","color/transform/domain.wgsl","color/transform/chunk.wgsl","color/transform/contexts.wgsl","color/transform/coder.wgsl","color/transform/means.wgsl","color/transform/levels.wgsl","color/transform/palette.wgsl","color/transform/region.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","tables: read-only-storage","pictures: storage","scratch: storage"]},{name:"transform-8bit",about:"8-bit colour by a transform in space and time: `CTR8`.",entry:"show_regions",workgroup:64,reader:"transform-read-8bit",files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/samples_8.wgsl","color/transform/domain_bytes.wgsl","color/transform/domain.wgsl","color/transform/chunk.wgsl","color/transform/contexts.wgsl","color/transform/reconstruct.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","tables: read-only-storage","pictures: storage","scratch: storage"]},{name:"transform-read-half",about:"Reads the regions of `CTRH`, an invocation each.",entry:"read_regions",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/halves.wgsl","color/samples_half.wgsl","color/transform/domain_halves.wgsl","color/transform/domain.wgsl","color/transform/chunk.wgsl","color/transform/contexts.wgsl","color/transform/coder.wgsl","color/transform/means.wgsl","color/transform/levels.wgsl","color/transform/palette.wgsl","color/transform/region.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","tables: read-only-storage","pictures: storage","scratch: storage"]},{name:"transform-half",about:"Half floats by a transform in space and time: `CTRH`.",entry:"show_regions",workgroup:64,reader:"transform-read-half",files:["shared/layout.wgsl","shared/jobs.wgsl","shared/bytes.wgsl","color/blend.wgsl","color/halves.wgsl","color/samples_half.wgsl","color/transform/domain_halves.wgsl","color/transform/domain.wgsl","color/transform/chunk.wgsl","color/transform/contexts.wgsl","color/transform/reconstruct.wgsl"],bindings:["units: read-only-storage","records: read-only-storage","jobs: read-only-storage","boxes: read-only-storage","stream: read-only-storage","tables: read-only-storage","pictures: storage","scratch: storage"]},{name:"plan-records",about:"Finds the next record of each depth or material unit, and sizes the dispatch that applies them.",entry:"plan_records",workgroup:256,files:["shared/layout.wgsl","shared/sums.wgsl","shared/plan.wgsl","depth/record_table.wgsl"],bindings:["units: read-only-storage","chunks: read-only-storage","records: read-only-storage","items: read-only-storage","states: storage","jobs: storage","dispatch: storage"]},{name:"plan-cells",about:"Finds the two keyframes of each colour cell, and sizes the dispatch that blends them.",entry:"plan_cells",workgroup:256,files:["shared/layout.wgsl","shared/sums.wgsl","shared/plan.wgsl","shared/bytes.wgsl","color/cells.wgsl"],bindings:["chunks: read-only-storage","records: read-only-storage","items: read-only-storage","stream: read-only-storage","states: storage","jobs: storage","dispatch: storage"]},{name:"bc1",about:"All pixels of BC1 blocks.",entry:"decode_bc1",workgroup:64,files:["shared/layout.wgsl","block/bc1.wgsl","block/decode_bc1.wgsl"],bindings:["blocks: read-only-storage","texels: storage"]},{name:"bc4",about:"All pixels of BC4 blocks.",entry:"decode_bc4",workgroup:64,files:["shared/layout.wgsl","block/bc4.wgsl","block/decode_bc4.wgsl"],bindings:["blocks: read-only-storage","texels: storage"]},{name:"bc5",about:"All pixels of BC5 blocks.",entry:"decode_bc5",workgroup:64,files:["shared/layout.wgsl","block/bc4.wgsl","block/bc5.wgsl","block/decode_bc5.wgsl"],bindings:["blocks: read-only-storage","texels: storage"]},{name:"bc6h",about:"All pixels of BC6H blocks.",entry:"decode_bc6h",workgroup:64,files:["shared/layout.wgsl","block/bptc.wgsl","block/bc6h.wgsl","block/decode_bc6h.wgsl"],bindings:["blocks: read-only-storage","texels: storage"]},{name:"bc7",about:"All pixels of BC7 blocks.",entry:"decode_bc7",workgroup:64,files:["shared/layout.wgsl","block/bptc.wgsl","block/bc7.wgsl","block/decode_bc7.wgsl"],bindings:["blocks: read-only-storage","texels: storage"]},{name:"texels",about:"Inverse depths of texels from the depth codes of tiles.",entry:"write_depths",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","march/texels.wgsl"],bindings:["pictures: read-only-storage","tables: read-only-storage","jobs: read-only-storage","planes: storage"]},{name:"squares",about:"One level of the depth pyramids from the level below.",entry:"write_squares",workgroup:64,files:["shared/layout.wgsl","shared/jobs.wgsl","march/pyramid.wgsl"],bindings:["jobs: read-only-storage","planes: storage"]},{name:"render",about:"Ray marching that tests every sample along a ray.",entry:"render",workgroup:64,files:["march/layout.wgsl","march/light_field.wgsl","march/marched_views.wgsl","march/active_views.wgsl","march/counters.wgsl","march/ray.wgsl","march/intersect.wgsl","march/interpolate.wgsl","march/shading.wgsl","march/diffuse.wgsl","march/layers.wgsl","march/render.wgsl"],bindings:["scene: read-only-storage","views: read-only-storage","faces: read-only-storage","distances_m: read-only-storage","inverse_depths: uint","colors: unfilterable-float","pixels: storage","counts: storage"]},{name:"render-pyramid",about:"Ray marching that skips segments which depth pyramids prove empty.",entry:"render",workgroup:64,files:["march/layout.wgsl","march/light_field.wgsl","march/marched_views.wgsl","march/active_views.wgsl","march/counters.wgsl","march/ray.wgsl","march/segments.wgsl","march/interpolate.wgsl","march/shading.wgsl","march/diffuse.wgsl","march/layers.wgsl","march/render.wgsl"],bindings:["scene: read-only-storage","views: read-only-storage","faces: read-only-storage","distances_m: read-only-storage","inverse_depths: uint","colors: unfilterable-float","pixels: storage","counts: storage","pyramids: uint"]},{name:"render-effects",about:"Ray marching with reflection and refraction.",entry:"render",workgroup:64,files:["march/layout.wgsl","march/light_field.wgsl","march/marched_views.wgsl","march/active_views.wgsl","march/counters.wgsl","march/ray.wgsl","march/segments.wgsl","march/interpolate.wgsl","march/shading.wgsl","march/material.wgsl","march/normal.wgsl","march/solid.wgsl","march/secondary_rays.wgsl","march/layers.wgsl","march/render.wgsl"],bindings:["scene: read-only-storage","views: read-only-storage","faces: read-only-storage","distances_m: read-only-storage","inverse_depths: uint","colors: unfilterable-float","pixels: storage","counts: storage","pyramids: uint","materials: unfilterable-float"]},{name:"slices",about:"The lines that pixels of output views show, in epipolar slices.",entry:"find_winners",workgroup:256,files:["shared/product.wgsl","epipolar/layout.wgsl","epipolar/lines.wgsl","epipolar/slice.wgsl"],bindings:["block: read-only-storage","starts: read-only-storage","run_starts: read-only-storage","runs: read-only-storage","depths: read-only-storage","places: read-only-storage","winners: storage","fragments: storage"]},{name:"line-light",about:"Light of the lines that pixels of output views show.",entry:"shade",workgroup:64,files:["color/blend.wgsl","color/halves.wgsl","epipolar/layout.wgsl","epipolar/beside.wgsl","epipolar/interpolate.wgsl"],bindings:["block: read-only-storage","starts: read-only-storage","lights: read-only-storage","winners: read-only-storage","pixels: storage","wanted: storage"]},{name:"line-highlights",about:"Highlights of the lines that pixels of output views show.",entry:"add_highlights",workgroup:64,files:["epipolar/layout.wgsl","epipolar/beside.wgsl","epipolar/highlights.wgsl"],bindings:["block: read-only-storage","starts: read-only-storage","winners: read-only-storage","split_starts: read-only-storage","splits: read-only-storage","eyes: read-only-storage","pixels: storage"]},{name:"active-counts",about:"Active pixels of each row of a layer of a source view.",entry:"count_active",workgroup:256,files:["epipolar/layout.wgsl","epipolar/active.wgsl"],bindings:["block: read-only-storage","shown: read-only-storage","counts: storage"]},{name:"compact",about:"Active pixels of a layer of a source view without gaps.",entry:"compact",workgroup:256,files:["epipolar/layout.wgsl","shared/sums.wgsl","epipolar/compact.wgsl"],bindings:["block: read-only-storage","shown: read-only-storage","counts: read-only-storage","active_pixels: storage"]},{name:"erosion-edges",about:"Edges up to each pixel of the scanlines of source views.",entry:"count_edges",workgroup:256,files:["epipolar/layout.wgsl","shared/sums.wgsl","epipolar/edges.wgsl"],bindings:["block: read-only-storage","moves: read-only-storage","edges: storage"]},{name:"erosion",about:"Pixels of source views from which an edge lies on the way to their place in another one.",entry:"count_eroded",workgroup:256,files:["epipolar/layout.wgsl","epipolar/erosion.wgsl"],bindings:["block: read-only-storage","moves: read-only-storage","edges: read-only-storage","eroded: storage"]}],drawings:[{name:"triangles",about:"The nearest triangle at each pixel, behind those of a former pass.",vertex:"place_corner",fragment:"name_triangle",files:["drawing/layout.wgsl","epipolar/triangles.wgsl"],bindings:["picture: read-only-storage","corners: read-only-storage","before: uint"],targets:["triangles: index"]},{name:"quads-painter",about:"Textured triangles blended in their order, and counted.",vertex:"place",fragment:"paint",files:["drawing/layout.wgsl","simplify/place.wgsl","simplify/texels.wgsl","simplify/painter.wgsl"],bindings:["picture: read-only-storage","corners: read-only-storage","light_of_codes: read-only-storage","atlas: uint"],targets:["light: over","counts: add"]},{name:"quads-z-buffer",about:"The nearest of textured triangles whose alpha covers the sample.",vertex:"place",fragment:"cover",files:["drawing/layout.wgsl","simplify/place.wgsl","simplify/texels.wgsl","simplify/z_buffer.wgsl"],bindings:["picture: read-only-storage","corners: read-only-storage","light_of_codes: read-only-storage","atlas: uint"],targets:["light: nearest"]},{name:"quads-overdraw",about:"Counts textured triangles over each sample.",vertex:"place",fragment:"count",files:["drawing/layout.wgsl","simplify/place.wgsl","simplify/overdraw.wgsl"],bindings:["picture: read-only-storage","corners: read-only-storage"],targets:["counts: add"]}]};var Jn=`// BC1 (blocks.md 3). Mirrors src/codec/block/formats.rs.

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
`;var Qn=`// BC4 (blocks.md 4). Mirrors src/codec/block/formats.rs.

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
`;var Zn=`// BC5 (blocks.md 5). Mirrors src/codec/block/formats.rs. Needs \`bc4_texel\`.

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
`;var es=`// BC6H UF16 (blocks.md 7). Mirrors src/codec/block/bc6h.rs. Needs bptc.wgsl.

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
`;var ts=`// BC7 (blocks.md 8). Mirrors src/codec/block/bc7.rs. Needs bptc.wgsl.

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
`;var rs=`// Functions and tables shared by BC6H and BC7 (blocks.md 6). Mirrors src/codec/block/bptc.rs.

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
`;var ns=`// Interpolation between two keyframes (arithmetic.md 3, 4). Mirrors src/codec/color/blend.rs.

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
`;var ss=`// Plans colour cells: the two keyframes that each listed cell blends, and their weight (color.md 4). Mirrors
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
`;var os=`// Decodes cells whose keyframes may be block-compressed (color.md 4): \`CellState\` of src/codec/decode/decoder.rs. An invocation
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
`;var is=`// Decodes cells whose keyframes are raw samples (color.md 4): \`CellState\` of src/codec/decode/decoder.rs. An invocation writes a
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
`;var as=`// Packing and interpolation of half-float pixels: \`impl Sample for HalfKey\` of src/codec/color/blend.rs. Needs \`lerp\`.

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
`;var cs=`// Keyframes in BC1 blocks (color.md 4). Mirrors src/codec/color/keyframe_blocks.rs. Needs \`word_at\` and \`bc1_texels\`.

fn keyframe_block(keyframe: Record, block: u32, out: ptr<function, array<u32, 16>>) {
    let at = keyframe.at + 8u * block;
    bc1_texels(vec2u(word_at(at), word_at(at + 4u)), out);
}
`;var us=`// Keyframes in BC6H blocks (color.md 4). Mirrors src/codec/color/keyframe_blocks.rs. Needs \`word_at\` and \`bc6h_texels\`.

fn keyframe_block(keyframe: Record, block: u32, out: ptr<function, array<vec2u, 16>>) {
    let at = keyframe.at + 16u * block;
    bc6h_texels(vec4u(word_at(at), word_at(at + 4u), word_at(at + 8u), word_at(at + 12u)), out);
}
`;var ls=`// Keyframes in BC7 blocks (color.md 4). Mirrors src/codec/color/keyframe_blocks.rs. Needs \`word_at\` and \`bc7_texels\`.

fn keyframe_block(keyframe: Record, block: u32, out: ptr<function, array<u32, 16>>) {
    let at = keyframe.at + 16u * block;
    bc7_texels(vec4u(word_at(at), word_at(at + 4u), word_at(at + 8u), word_at(at + 12u)), out);
}
`;var ds=`// Cells of 8-bit samples (color.md 3, 4): \`impl Sample for u8\` of src/codec/color/blend.rs. Needs \`word_at\`, \`lerp\` and \`pictures\`.

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
`;var fs=`// Cells of half-float samples (color.md 3, 4). Needs \`word_at\`, \`half_at\`, \`pack\` and \`pictures\`.

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
`;var ms=`// Declarations of both kernels of the transform codec: the words of a chunk, and the scratch memory of a region, through which
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
`;var hs=`// Reads symbols and raw bits of a region's substream (color.md 6.6, 7). Mirrors src/codec/color/transform/coder.rs and
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
`;var ps=`// Contexts of symbols (color.md 6.6), and offsets of the format's tables in \`tables\` (src/kernels/transform_tables.rs). Mirrors
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
`;var bs=`// Conversion between keys and channels (color.md 6.2). Mirrors src/codec/color/transform/domain.rs. Needs \`slope_of\` and \`MIDDLE\`.

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
`;var ws=`// 8-bit samples in the transform codec: \`Domain::BYTES\` of src/codec/color/transform/domain.rs.

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
`;var gs=`// Half-float samples in the transform codec: \`Domain::HALVES\` of src/codec/color/transform/domain.rs. Needs \`bits_of\`.

const FRACTION_BITS: u32 = 0u;
const FINE_BITS: u32 = 0u;
const KEY_BITS: u32 = 16u;
const MIDDLE: i32 = 0xbc00;
const MIN_KEY: i32 = 0x0400;
const MAX_KEY: i32 = 0xfbff;

fn sample_of(keys: vec3i) -> vec3u {
    return bits_of(vec3u(keys));
}
`;var ys=`// Reads the levels of a transformed block (color.md 6.6), and accumulates the spatial coefficients of one frame while reading.
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
`;var _s=`// Steps (color.md 6.3), means of 4x4 squares, and the levels predicted from them (color.md 6.5). Mirrors
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
`;var vs=`// Palette blocks (color.md 6.8). Mirrors src/codec/color/transform/palette.rs.

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
`;var xs=`// Inverse transform of one frame of a region (color.md 6.3), one workgroup per region: all invocations transform one block at a
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
`;var ks=`// Reads the block tree of a region (color.md 6.4), one region per invocation. Mirrors src/codec/color/transform/region.rs and
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
`;var Es=`// BC4w blocks (depth.md 8). Mirrors src/codec/depth/bc4w.rs. Needs \`stream\`.

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
`;var Ss=`// Biquadratic functions (arithmetic.md 6). Mirrors src/codec/depth/biquadratic.rs. Needs \`stream\`.

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
`;var Rs=`// Block tiles of block-compressed boxes (depth.md 14): finds the block that holds a pixel. Mirrors src/codec/depth/block_tiles.rs;
// the table of boxes has one row per piece.

// Returns the index of the block that holds a pixel of a piece, and the index of the pixel in that block.
fn piece_block(row: BoxRow, x: u32, y: u32) -> vec2u {
    let columns = (row.width + 3u) / 4u;
    return vec2u(y / 4u * columns + x / 4u, y % 4u * 4u + x % 4u);
}
`;var Ms=`// Block tiles in BC1 blocks or as raw values (depth.md 14): \`impl Texel for [u8; 3]\` of src/codec/depth/texel.rs. Needs
// \`piece_block\`, \`word_at\`, \`stored_value\` and \`bc1_texel\`.

fn box_value(row: BoxRow, x: u32, y: u32) -> u32 {
    if (row.coding != BOX_BLOCKS) {
        return stored_value(row, x, y);
    }
    let place = piece_block(row, x, y);
    let at = row.at + 8u * place.x;
    return bc1_texel(vec2u(word_at(at), word_at(at + 4u)), place.y);
}
`;var Ts=`// Block tiles in BC5 blocks or as raw values (depth.md 14): \`impl Texel for u16\` of src/codec/depth/texel.rs. Needs \`piece_block\`,
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
`;var As=`// Boxes without block compression (depth.md 4). Needs \`stored_value\`.

fn box_value(row: BoxRow, x: u32, y: u32) -> u32 {
    return stored_value(row, x, y);
}
`;var Ps=`// Converts the value of a modelling function to a code (arithmetic.md 6, 7). Mirrors src/codec/depth/domain.rs. Needs \`log2_table\`.

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
`;var Cs=`// Platelets: two planes divided by a line (arithmetic.md 6). Mirrors src/codec/depth/platelet.rs. Needs \`stream\`.

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
`;var Ns=`// Plans depth units: the record that each listed unit applies next, and its amount of work (depth.md 4). A dispatch plans one
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
`;var Os=`// Records of boxes (depth.md 4). Mirrors src/codec/depth/records.rs. Needs \`units\`, \`records\`, \`jobs\` and \`boxes\`.

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
`;var Fs=`// Decodes nodes in the runtime form (depth.md 10; GDC 4, 5). Mirrors src/codec/depth/runtime.rs and src/codec/depth/nodes.rs.
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
`;var Us=`// Boxes of depth codes (depth.md 4). Mirrors \`impl Texel for u16\` of src/codec/depth/texel.rs.
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
`;var Ls=`// Boxes of material (depth.md 4, 5). Mirrors \`impl Texel for [u8; 3]\` of src/codec/depth/texel.rs. An invocation writes a pixel.
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
`;var Is=`// Occupancy of points: BetweenViewpointAndGeometry of algorithm 4 (CALF 6). Mirrors src/render/march/active_views.rs. Needs \`project\`,
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
`;var Bs=`// Counters of rendering. Mirrors src/render/march/counters.rs.

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
`;var Ds=`// Radiance of a surface without secondary rays. Needs \`light_of\`.

fn surface_light(ray: Ray, distance_m: f32, seen: Seen) -> vec3<f32> {
    return light_of(seen.color);
}
`;var Hs=`// Interpolates the colour of a point: CalculateColor of algorithm 4 (CALF 6). Mirrors src/render/march/interpolate.rs. Needs \`project\`
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
`;var Gs=`// Intersection of a ray with a surface: RayIntersection of algorithm 4 (CALF 6), testing every point. Mirrors
// src/render/march/intersect.rs. Needs \`is_surface\`.

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
`;var zs=`// Follows a primary ray through successive surfaces, each with its share of the ray, to the background. Mirrors
// src/render/march/layers.rs. Needs \`first_step\`, \`refined\`, \`seen_from_eye\`, \`background_color\`, \`surface_light\` and \`light_of\`.

const MIN_LAYER: f32 = 1.0 / 64.0;
const MAX_LAYERS = 8u;
const MAX_EXITS = 64u;

// Result of a primary ray. Mirrors src/render/march/samples.rs.
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
`;var Ws=`// Input of a picture, written by src/gpu/render/scene.rs; a test compares the two.

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
`;var js=`// Texels, and the projection of points into the images of a view (CALF 6). Mirrors \`View::project\` of src/render/views/light_field.rs
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
`;var Vs=`// Selects the views that are marched: all active views, or a single one (the nearest, or the environment map of a proxy).

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
`;var $s=`// Interpolates the material of a surface point: SampleMaterial of algorithm 4 (CALF 6.1). Mirrors
// src/render/march/specular/material.rs. Needs \`project\`, \`local_of\`, \`taps_around\` and \`DEPTH_EPSILON\`.

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
`;var Ks=`// Estimates the normal and curvature of a surface point from the depths around it (CALF 6.1). Mirrors
// src/render/march/specular/normal.rs. Needs \`project\`, \`local_of\`, \`texel_material\` and \`DEPTH_EPSILON\`.

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
`;var qs=`// Computes the maximum inverse depths of squares of texels, one pyramid level per dispatch: \`DepthPyramid::update\` of
// src/render/march/pyramid.rs. An invocation writes one square. Inverse depths are never negative, so their bits compare as integers.
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
`;var Xs=`// Rays, in metres from the eye, and the distances of their samples. Mirrors src/render/march/ray.rs.

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
`;var Ys=`// Renders from any eye: Main of algorithm 4 (CALF 6). Mirrors src/render/march/render.rs.
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
// rows. Mirrors src/render/march/samples.rs.
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
`;var Js=`// Secondary rays of reflective and refractive surfaces: CalculateColor_RR of algorithm 4 (CALF 6.1). Mirrors
// src/render/march/specular/secondary_rays.rs.
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
`;var Qs=`// Marches over whole segments of a ray that one view proves to be empty (CALF 6, algorithm 4). Mirrors src/render/march/segments.rs.
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

// Returns the step at which marching ends; \`scene.distance_count\` if the ray hits nothing. Mirrors src/render/march/segments.rs.
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
`;var Zs=`// Converts coded colours to linear RGB. Mirrors \`light_of\` of src/render/march/shading.rs.

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
`;var eo=`// Refraction through a solid (CALF 6.1). Mirrors src/render/march/specular/solid.rs. Needs \`patch_at\`, \`surface_material\`, \`fresnel\`,
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

// A sphere, or none. Mirrors src/render/march/specular/sphere.rs.
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
`;var to=`// Converts depth codes to inverse depths of the texels of a view (CALF 6.2): \`write_depth\` of src/render/views/face_cache.rs with
// \`InverseDepth\` of src/render/views/inverse_depth.rs. An invocation writes a texel. Needs \`job_of\`.

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
`;var ro=`// Unaligned little-endian reads of bytes, 16-bit and 32-bit words from \`stream\`.

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
`;var no=`// Maps an invocation to its job and its part of the job (GDC 5, algorithm 2). Needs \`jobs\`.

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
`;var so=`// Structs and constants of kernels.json; a test compares the two.

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
`;var oo=`// Computes the size of the next dispatch; shared by the planning kernels. Needs \`items\`, \`jobs\` and \`dispatch\`.

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
`;var io=`// Returns the 64-bit product of two words, low word first, computed from four 16-bit products.
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
`;var ao=`// Prefix sums over the invocations of a workgroup.

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
`;var bu=["nodes","boxes-codes","boxes-material","cells-8bit","cells-half","boxes-bc5","boxes-bc1","cells-bc1","cells-bc7","cells-bc6h","transform-read-8bit","transform-8bit","transform-read-half","transform-half","plan-records","plan-cells","texels","squares","render","render-pyramid","render-effects"],wu={"block/bc1.wgsl":Jn,"block/bc4.wgsl":Qn,"block/bc5.wgsl":Zn,"block/bc6h.wgsl":es,"block/bc7.wgsl":ts,"block/bptc.wgsl":rs,"color/blend.wgsl":ns,"color/cells.wgsl":ss,"color/cells_of_blocks.wgsl":os,"color/cells_of_samples.wgsl":is,"color/halves.wgsl":as,"color/keyframes_bc1.wgsl":cs,"color/keyframes_bc6h.wgsl":us,"color/keyframes_bc7.wgsl":ls,"color/samples_8.wgsl":ds,"color/samples_half.wgsl":fs,"color/transform/chunk.wgsl":ms,"color/transform/coder.wgsl":hs,"color/transform/contexts.wgsl":ps,"color/transform/domain.wgsl":bs,"color/transform/domain_bytes.wgsl":ws,"color/transform/domain_halves.wgsl":gs,"color/transform/levels.wgsl":ys,"color/transform/means.wgsl":_s,"color/transform/palette.wgsl":vs,"color/transform/reconstruct.wgsl":xs,"color/transform/region.wgsl":ks,"depth/bc4w.wgsl":Es,"depth/biquadratic.wgsl":Ss,"depth/block_tiles.wgsl":Rs,"depth/block_tiles_bc1.wgsl":Ms,"depth/block_tiles_bc5.wgsl":Ts,"depth/boxes_of_values.wgsl":As,"depth/domain.wgsl":Ps,"depth/platelet.wgsl":Cs,"depth/record_table.wgsl":Ns,"depth/records.wgsl":Os,"depth/runtime.wgsl":Fs,"depth/texel_codes.wgsl":Us,"depth/texel_material.wgsl":Ls,"march/active_views.wgsl":Is,"march/counters.wgsl":Bs,"march/diffuse.wgsl":Ds,"march/interpolate.wgsl":Hs,"march/intersect.wgsl":Gs,"march/layers.wgsl":zs,"march/layout.wgsl":Ws,"march/light_field.wgsl":js,"march/marched_views.wgsl":Vs,"march/material.wgsl":$s,"march/normal.wgsl":Ks,"march/pyramid.wgsl":qs,"march/ray.wgsl":Xs,"march/render.wgsl":Ys,"march/secondary_rays.wgsl":Js,"march/segments.wgsl":Qs,"march/shading.wgsl":Zs,"march/solid.wgsl":eo,"march/texels.wgsl":to,"shared/bytes.wgsl":ro,"shared/jobs.wgsl":no,"shared/layout.wgsl":so,"shared/plan.wgsl":oo,"shared/product.wgsl":io,"shared/sums.wgsl":ao},gu=["read-only-storage","storage","uint","unfilterable-float"];function yu(s){return gu.includes(s)}function co(s){let e=Ne.kernels.find(t=>t.name===s);if(e===void 0)throw new Error(`shaders/kernels.json has no kernel ${s}`);return e}function fe(s){let{entry:e,workgroup:t,bindings:r,reader:n}=co(s),o=r.map(a=>{let[c="",u=""]=a.split(": ");if(!yu(u))throw new Error(`shaders/kernels.json: ${u} is no kind of binding`);return{name:c,kind:u}}),i=bu.find(a=>a===n);if(i!==n)throw new Error(`shaders/kernels.json: ${n} is no kernel of the player`);return{name:s,entry:e,workgroup:t,bindings:o,reader:i}}function uo(s){return co(s).files.map(t=>{let r=wu[t];if(r===void 0)throw new Error(`${t} of kernel ${s} is not part of the player`);return r}).join(`
`)}var _u=2**30,lo=8,vu=["maxBufferSize","maxStorageBufferBindingSize","maxTextureArrayLayers","maxTextureDimension2D"],z=class extends Error{name="NoWebGpuError"},O=class extends Error{name="DeviceError"};function xu({kind:s},e){let t=GPUShaderStage.COMPUTE;return s==="read-only-storage"||s==="storage"?{binding:e,visibility:t,buffer:{type:s}}:{binding:e,visibility:t,texture:{sampleType:s,viewDimension:"2d-array"}}}async function Pr(){if(!globalThis.isSecureContext)throw new z("WebGPU needs a secure page: open it by https, or from localhost.");if(typeof navigator>"u"||!("gpu"in navigator))throw new z("This browser has no WebGPU.");let s=await navigator.gpu.requestAdapter({powerPreference:"high-performance"}).catch(()=>null);if(s===null)throw new z("This browser has WebGPU, but no graphics device that it may use.");return s}function fo({info:{vendor:s,architecture:e}}){return[s,e].filter(t=>t!=="").join(" ")||"graphics device"}function Cr(s){return/swiftshader|llvmpipe|lavapipe|software|basic render/iu.test(fo(s))}var lt=class s{device;queue;name;isSoftware;maxBindingBytes;hasTimestamps;lost;onError=()=>{};#e=0;#t;#r=new Map;constructor(e,t){let{maxStorageBufferBindingSize:r,maxBufferSize:n}=e.limits,o=Math.min(r,n,_u);this.device=e,this.queue=e.queue,this.name=fo(t),this.isSoftware=Cr(t),this.maxBindingBytes=Math.floor(o/16)*16,this.hasTimestamps=e.features.has("timestamp-query"),this.lost=e.lost.then(({reason:i,message:a})=>a||i||"unknown"),e.addEventListener("uncapturederror",i=>this.onError(i.error.message))}static async open(e){let t=e??await Pr();if(t.limits.maxStorageBuffersPerShaderStage<lo)throw new z(`The graphics device gives a kernel fewer than ${lo} buffers.`);let r=t.features.has("timestamp-query")?["timestamp-query"]:[],n=Object.fromEntries(vu.map(a=>[a,t.limits[a]])),o={label:"lightfold",requiredFeatures:r,requiredLimits:n},i=await t.requestDevice(o).catch(a=>{throw new z(`The graphics device cannot be opened: ${String(a)}.`)});return new s(i,t)}get bytes(){return this.#e}pipeline(e){let t=this.#r.get(e)??this.#n(e);return this.#r.set(e,t),t}async#n(e){let{entry:t,bindings:r}=fe(e),n=this.device.createShaderModule({label:e,code:uo(e)}),o=this.device.createBindGroupLayout({label:e,entries:r.map(xu)});return{pipeline:await this.device.createComputePipelineAsync({label:e,layout:this.device.createPipelineLayout({label:e,bindGroupLayouts:[o]}),compute:{module:n,entryPoint:t}}),layout:o,bindings:r}}bind({layout:e,bindings:t},r){let n=t.map(({name:o},i)=>({binding:i,resource:r(o)}));return this.device.createBindGroup({layout:e,entries:n})}check(e,t){if(4*t>this.maxBindingBytes)throw new O(`${e} takes ${4*t} bytes; the graphics device allows ${this.maxBindingBytes}.`)}buffer(e,t,r=0){this.check(e,t);let n=Math.max(t,4)*4,o=GPUBufferUsage.STORAGE|GPUBufferUsage.COPY_DST|GPUBufferUsage.COPY_SRC,i=this.device.createBuffer({label:e,size:n,usage:o|r});return this.#e+=n,i}scratch(e){let t=this.#t;return t!==void 0&&4*e<=t.size?t:(this.#t=this.buffer("scratch",e),t!==void 0&&this.release(t),this.#t)}filled(e,t){let r=this.buffer(e,t.length);return this.write(r,0,t),r}release(e){this.#e-=e.size,e.destroy()}write(e,t,r){this.queue.writeBuffer(e,t,r.buffer,r.byteOffset,r.byteLength)}async read(e,t,r){if(r===0)return new Uint32Array;let n=GPUBufferUsage.MAP_READ|GPUBufferUsage.COPY_DST,o=this.device.createBuffer({label:"reading back",size:4*r,usage:n});try{return this.submit(i=>i.copyBufferToBuffer(e,t,o,0,4*r)),await o.mapAsync(GPUMapMode.READ),new Uint32Array(o.getMappedRange().slice(0))}finally{o.destroy()}}submit(e){let t=this.device.createCommandEncoder();e(t),this.queue.submit([t.finish()])}destroy(){this.device.destroy()}};function dt([s,e]){let t=[],[r,n]=[s,e];for(;r>1||n>1||t.length===0;)[r,n]=[Math.ceil(r/2),Math.ceil(n/2)],t.push([r,n]);return t}function ft([s,e,t,r],n){let o=(l,d)=>{let f=l>>n+1;return[f,(l+d-1>>n+1)-f+1]},[[i,a],[c,u]]=[o(s,t),o(e,r)];return[i,c,a,u]}function mo([s,e],t,r){let[n,o]=[Math.floor(r.side/s),Math.floor(r.side/e)],i=Math.ceil(t/r.layers),a=Math.max(Math.min(i,n),1),c=Math.ceil(i/a);if(n===0||c>o){let u=n*o*r.layers;throw new y(`${t} images of ${s}x${e} texels are needed at once, and the graphics device holds ${u} of this size.`)}return{columns:a,rows:c,layers:Math.ceil(t/(a*c))}}function ho({columns:s,rows:e},t){let r=t%(s*e);return{column:r%s,row:Math.floor(r/s),layer:Math.floor(t/(s*e))}}function po({views:s}){let e=s.flatMap(({faces:t})=>t.map(({size:r})=>r));return[Math.max(...e.map(([t])=>t)),Math.max(...e.map(([,t])=>t))]}function bo([s,e]){return 2**Math.ceil(Math.log2(Math.max(s,e)))}function wo(s){let[e,t]=po(s),r=s.views.some(({faces:o})=>o.some(({material:i})=>i!==void 0)),n=4+(s.coding.name==="light"?8:4)+(r?4:0);return e*t*n+4*Math.ceil(e/2)*bo([e,t])}var mt=class{constructor(e,t,r){this.gpu=e;let{maxTextureDimension2D:n,maxTextureArrayLayers:o}=e.device.limits,i=po(t);this.pyramidRows=bo(i);let a=[Math.ceil(i[0]/2),this.pyramidRows],c=[Math.max(i[0],a[0]),Math.max(i[1],a[1])];this.#t=mo(c,r,{side:n,layers:o}),this.#e=i;let u=t.views.some(({faces:d})=>d.some(({material:f})=>f!==void 0));this.#r={inverse_depths:this.#o("inverse_depths",i,"r32uint"),pyramids:this.#o("pyramids",a,"r32uint"),colors:this.#o("colors",i,t.coding.name==="light"?"rgba16float":"rgba8unorm"),materials:this.#o("materials",u?i:[1,1],"rgba8unorm")};let l=d=>this.#r[d].createView({dimension:"2d-array"});this.#n={inverse_depths:l("inverse_depths"),pyramids:l("pyramids"),colors:l("colors"),materials:l("materials")},this.#s=Array.from({length:r},(d,f)=>r-1-f)}gpu;pyramidRows;#e;#t;#r;#n;#s;take(){return this.#s.pop()}free(e){this.#s.push(e)}view(e){return e in this.#n?this.#n[e]:void 0}origin(e){let{column:t,row:r,layer:n}=ho(this.#t,e),[o,i]=this.#e;return{texels:[t*o,r*i],pyramid:[t*Math.ceil(o/2),r*this.pyramidRows],layer:n}}overlayTexture(){return this.#o("overlay",this.#e,"rgba8unorm")}upload(e,t,[r,n,o,i],a){let{texels:[c,u],layer:l}=this.origin(t),d=typeof e=="string"?this.#r[e]:e;this.gpu.queue.writeTexture({texture:d,origin:[c+r,u+n,l]},a,{bytesPerRow:o*4*a.BYTES_PER_ELEMENT},[o,i,1])}copyColor(e,t,r,n){let{texels:o,layer:i}=this.origin(t);this.#i(e,n,{texture:this.#r.colors,at:[...o,i]},r)}copyDepth(e,t,r,{planes:n,face:o}){let{texels:i,pyramid:a,layer:c}=this.origin(t);n.levels(o).forEach((u,l)=>{let d=l===0?r:ft(r,l-1),f={buffer:n.planes,at:u.at+d[1]*u.pitch+d[0],pitch:u.pitch};if(l===0)this.#i(e,f,{texture:this.#r.inverse_depths,at:[...i,c]},d);else{let m=this.pyramidRows-this.pyramidRows/2**(l-1);this.#i(e,f,{texture:this.#r.pyramids,at:[a[0],a[1]+m,c]},d)}})}#o(e,[t,r],n){let{columns:o,rows:i,layers:a}=this.#t;return this.gpu.device.createTexture({label:e,size:[t*o,r*i,a],format:n,usage:GPUTextureUsage.TEXTURE_BINDING|GPUTextureUsage.COPY_DST})}#i(e,{buffer:t,at:r,pitch:n},{texture:o,at:[i,a,c]},[u,l,d,f]){let m=f>1?{offset:4*r,bytesPerRow:4*n}:{offset:4*r};e.copyBufferToTexture({buffer:t,...m},{texture:o,origin:[i+u,a+l,c]},[d,f,1])}};function go({eye:s,yaw:e,pitch:t},r,n){let o=[-Math.sin(e)*Math.cos(t),Math.sin(t),-Math.cos(e)*Math.cos(t)],i=[Math.cos(e),0,-Math.sin(e)],a=Math.tan(r*Math.PI/360);return{eye:s,axes:[o,i,fr(o,i)],half:[a*n,a]}}function yo(s,e){let t=r=>({...s,eye:j(s.eye,N(s.axes[1],r))});return[t(-e/2),t(e/2)]}function _o(s,e){let t=({eye:n,axes:o,half:i})=>[...n,...o.flat(),...i],r=t(e);return t(s).every((n,o)=>n===r[o])}function vo(s,[e,t],r){let[n,o,i,a]=r;return s===6?{scale:[n,o],center:[i,a]}:{scale:[e/2,t/2],center:[e/2,t/2]}}function ht({scale:s,center:e},t,r){let{fround:n}=Math,o=(c,u)=>n(n(c+.5-n(e[u]))/n(s[u])),[i,a]=[o(t,0),o(r,1)];return n(Math.sqrt(n(n(1+n(i*i))+n(a*a))))}function xo(s){return s.name==="light"?0:s.transfer==="linear"?1:2}function me({depth:s,color:e,alpha:t,material:r}){return[s,e,t,r].filter(n=>n!==void 0)}function Nr({faces:s}){return s.map(t=>{let r=me(t),n=r.map(({firstFrame:o,frameCount:i})=>o+i-1);return[Math.max(...r.map(({firstFrame:o})=>o)),Math.min(...n)]}).filter(([t,r])=>t<=r)}function ko(s,e){return Nr(s).some(([t,r])=>t<=e&&e<=r)}function ku({isHalf:s,transfer:e,exposureEv:t}){return s?{name:"light"}:{name:"codes",transfer:e,exposureEv:t}}function Eu(s,e){let[t,r]=e.size,n=me(e).find(o=>o.width!==t||o.height!==r);if(n!==void 0)throw new y(`Probe ${s}, face ${e.face}: ${n.kind} has ${n.width}x${n.height} pixels and depth ${t}x${r}; rendering takes images of one size.`)}function Eo({streams:s,probes:e}){let t=new Map(s.map(o=>[`${o.probe} ${o.face} ${o.kind}`,o])),r=new Map,n;for(let o of s){let{header:i,probe:a,face:c,width:u,height:l}=o,d=F=>t.get(`${a} ${c} ${F}`),f=d("color");if(i.kind!=="depth"||f?.header.kind!=="color")continue;let m=ku(f.header);if(n??=m,JSON.stringify(n)!==JSON.stringify(m))throw new y("Colors of this container are coded in more than one way; the player takes one.");let{name:h,orientation:b,intrinsics:w}=e[a],_=[u,l],v=vo(c,_,w),x={face:c,size:_,map:v,depth:o,header:i,color:f,alpha:d("alpha"),material:d("material")};if(Eu(h,x),We(b)===void 0)throw new y(`Probe ${h}: its orientation is no rotation.`);let P=r.get(a)??{probe:a,faces:[],...Su(s,a)};P.faces.push(x),r.set(a,P)}if(n===void 0)throw new y("No probe of this container has both color and depth, which rendering takes.");return{views:[...r.values()],coding:n}}function Su(s,e){let[t,r]=[1/0,0];for(let{header:n,probe:o}of s)o===e&&n.kind==="depth"&&(t=Math.min(t,n.range.nearM),r=Math.max(r,n.range.farM));return{nearM:t,farM:r}}function So(s,e,t){let r=s.map(({view:n,position:o})=>({view:n,distanceM:fn(o,e)}));return r.sort((n,o)=>n.distanceM-o.distanceM||n.view-o.view),r.slice(0,Math.max(t,1)).map(({view:n})=>n)}function Ru(s){let e=new Map;for(let{probe:t,header:r}of s)r.kind==="depth"&&e.set(t,Math.min(r.range.nearM,e.get(t)??1/0));return e}var Oe=class{#e;#t;#r=[];#n=new Map;constructor(e){this.#e=e,this.#t=Ru(e.streams)}look(e){e.length===this.#r.length&&e.every((r,n)=>_o(r,this.#r[n]))||(this.#r=e,this.#n.clear())}units(e){let t=this.#n.get(e.index)??this.#s(e);return this.#n.set(e.index,t),t}sees(e,t){return this.units(e)[t]===1}#s(e){let t=this.#e.probes[e.probe];return(this.#e.footage.poses.get(t.name)??[]).length>0?new Uint8Array(this.#e.unitCount(e.index)).fill(1):k().visibleUnits(e,t,this.#t.get(e.probe)??0,this.#r)}};function pt({shown:s,next:[e,t]},r){return r===s||r>=e&&r<=t}function bt(s,e,t,r){let n=s.chunkIndex(e,t,r);if(n<0)return;let o=s.placeOf(n)==="last"?-1:n+1;return{unit:t,frame:r,chunk:n,next:o}}function te({container:s,store:e},t,r){let n=s.chunks[t],o=e.get(n);if(o===void 0){r.push(n);return}return{chunk:n,stored:o,area:s.areaOf(t)}}var Ro=64<<20,Mu=8,wt=class{constructor(e){this.decoding=e}decoding;#e=new Map;#t=new Set;#r=[];#n=new Set;#s=new Map;#o=0;#i=new Set;show(e,t){this.#t=new Set(e.map(he));let r=[],n=0;for(let i of e){if(n+=this.#a(i),n>Ro||this.#i.has(i.chunk))continue;let a=he(i),c=this.#e.get(a);c!==void 0&&this.#f(a,c),(c?.chunk!==i.chunk||c.frame!==i.frame)&&r.push(i)}let o=i=>this.#s.get(he(i))??-1;return this.#r=r.sort((i,a)=>o(i)-o(a)),this.#l(t),r.length}of(e,t){return this.#e.get(he({stream:e,unit:t}))}clear(){this.#e.clear(),this.#t.clear(),this.#r=[],this.#s.clear()}#a({stream:e,unit:t}){let[,,r,n]=this.decoding.container.unitRect(e,t);return r*n}#l(e){this.#r=this.#r.filter(t=>{if(this.#n.has(he(t))||this.#n.size>=Mu)return!0;let r=te(this.decoding,t.chunk,e);return r!==void 0&&this.#m(t,r),r===void 0})}#m(e,t){let r=he(e),{chunk:n,frame:o}=e;this.#n.add(r),this.#s.set(r,this.#o+=1);let i=()=>this.#t.has(r),a=l=>{l!==void 0&&i()&&(this.#f(r,{chunk:n,frame:o,bytes:l}),this.#p())},c=()=>{this.#i.add(n)};this.decoding.pool.codings(t,o-t.chunk.firstFrame,i).then(a,c).then(()=>{this.#n.delete(r),this.#l([]),this.decoding.onReady()})}#f(e,t){this.#e.delete(e),this.#e.set(e,t)}#p(){let e=[...this.#e.values()].reduce((t,r)=>t+r.bytes.length,0);for(let[t,r]of this.#e){if(e<=Ro)return;this.#e.delete(t),e-=r.bytes.length}}};function he({stream:s,unit:e}){return`${s} ${e}`}function Mo(s,[e,t],{eyes:r,overlay:n},o){let i=s.getContext("2d");if(i===null)throw new Error("The canvas cannot be drawn to.");let a=n===void 0?0:o.overlayShare,c={...o,overlayShare:a,isAnaglyph:o.stereo==="anaglyph"},u=k().presentPictures(n===void 0?r:[...r,n],c);[s.width,s.height]=o.size;let l=4*e*t;for(let d=0;d*l<u.length;d+=1){let f=new ImageData(u.slice(d*l,(d+1)*l),e,t);i.putImageData(f,d*(s.width-e),0)}}var Tu=["none","raw","biquadratic","platelet","bc4w","values","one value","blocks","background","plane","changed plane","quarters","pixels"];var Or=[{color:[213,94,0],codings:["raw","values","pixels"],name:"Raw codes; pixel by pixel"},{color:[240,228,66],codings:["biquadratic","plane"],name:"Biquadratic; plane carried on"},{color:[0,114,178],codings:["platelet","changed plane"],name:"Platelet; plane with a change"},{color:[204,121,167],codings:["bc4w","blocks","quarters"],name:"BC4w or BC5 block; quarters"},{color:[0,158,115],codings:["one value","background"],name:"One value; background"}],Au=.45,Pu=.3;function To(){return Array.from({length:256},(s,e)=>{let t=Tu[e&63],r=Or.find(({codings:o})=>o.includes(t)),n=((e&64)!==0?Au:1)*((e&128)!==0?Pu:1);return r?.color.map(o=>Math.round(o*n))})}var Fr=[18,20,26],Cu=[255,255,255],Nu=[255,176,0],Ao=[60,220,90],Ou=[255,120,40],Fu=[40,90,200],Uu=["probes","nodes","units","keyframes","fetched"],Po={name:"codes",transfer:"srgb",exposureEv:0},gt=.55;function yt({overlays:s}){return Uu.filter(e=>s.has(e))}var pe=class{constructor(e,t,r){this.container=e;this.catalogue=t;this.send=r}container;catalogue;send;#e=new Map;#t=Uint32Array.from(To(),e=>e===void 0?0:Fe(e));forget(e){this.catalogue.views[e].faces.forEach(({depth:t})=>this.#e.delete(t.index))}paint(e,t){for(let r of t.views)for(let n of this.catalogue.views[r].faces){let o=new Ur(n.size);e.forEach(i=>this.#r(i,{view:r,streams:n},t,o));for(let i of o.changesTo(this.#e.get(n.depth.index)))this.send({view:r,face:n.face},i,o.texels(i));o.forgetMaps(),this.#e.set(n.depth.index,o)}}#r(e,{view:t,streams:r},{view:{frame:n},isFresh:o,codings:i},a){let{depth:c,color:u}=r;e==="probes"?a.fill([0,0,...r.size],Lu(t/this.catalogue.views.length)):e==="nodes"?this.#n(c,(l,d)=>{let f=i(c.index,d),m=f===void 0?"":`${f.chunk} ${f.frame}`;a.map(l,{key:m,bytes:f?.bytes,words:this.#t})}):e==="units"?(this.#n(u,l=>a.frame(l,Nu)),this.#n(c,l=>a.frame(l,Cu))):(this.#n(c,(l,d)=>{let f=this.container.chunkIndex(c.index,d,n);if(!(f<0))if(e==="fetched")a.fill(l,o(f)?Ao:Fr);else{let{firstFrame:m,frameCount:h}=this.container.chunks[f],b=(n-m)/Math.max(1,h-1);a.fill(l,Ou.map((w,_)=>Math.round(w+(Fu[_]-w)*b)))}}),e==="fetched"&&this.#n(u,(l,d)=>{let f=this.container.chunkIndex(u.index,d,n);f>=0&&o(f)&&a.frame(l,Ao)}))}#n({index:e},t){for(let r=0;r<this.container.unitCount(e);r+=1)t(this.container.unitRect(e,r),r)}};function Lu(s){let e=t=>Math.round(255*(.55+.4*Math.cos(2*Math.PI*(s-t))));return[e(0),e(1/3),e(2/3)]}var Ur=class{constructor(e){this.size=e}size;#e=[];get#t(){return this.#e.map(({rect:e,color:t,isFrame:r})=>[...e,...t,r].join()).join(" ")}changesTo(e){return e===void 0||e.#t!==this.#t?[[0,0,...this.size]]:this.#e.filter(({map:t},r)=>t?.key!==e.#e[r].map?.key).map(({rect:t})=>t)}fill(e,t){this.#e.push({rect:e,color:t,isFrame:!1})}frame(e,t){this.#e.push({rect:e,color:t,isFrame:!0})}map(e,t){this.#e.push({rect:e,color:Fr,isFrame:!1,map:t})}forgetMaps(){this.#e.forEach(({map:e})=>e&&(e.bytes=void 0))}texels(e){let[t,r,n,o]=e,i=new Uint8Array(4*n*o),a=new Uint32Array(i.buffer);a.fill(Fe(Fr));for(let c of this.#e){let[u,l,d,f]=c.rect,[m,h]=[Math.max(u,t),Math.min(u+d,t+n)];for(let b=Math.max(l,r);b<Math.min(l+f,r+o)&&m<h;b+=1){let w=(b-r)*n+m-t;Iu(c,b,[m,h],a.subarray(w,w+h-m))}}return i}};function Iu(s,e,[t,r],n){let[o,i,a,c]=s.rect;if(s.map!==void 0){let{bytes:u,words:l}=s.map,d=(e-i)*a+t-o;for(let f=0;u!==void 0&&f<n.length;f+=1)n[f]=l[u[d+f]]||n[f]}else!s.isFrame||e===i||e===i+c-1?n.fill(Fe(s.color)):(t===o&&(n[0]=Fe(s.color)),r===o+a&&(n[n.length-1]=Fe(s.color)))}function Fe([s,e,t]){return(s|e<<8|t<<16|255<<24)>>>0}function Ue({view:{size:s,stereo:e}}){return[e==="side-by-side"?Math.ceil(s[0]/2):s[0],s[1]]}function Bu(s,e){let[t,r]=[Math.max(s[0],e[0]),Math.max(s[1],e[1])],[n,o]=[Math.min(s[0]+s[2],e[0]+e[2]),Math.min(s[1]+s[3],e[1]+e[3])];return t<n&&r<o?[t,r,n-t,o-r]:void 0}function _t(s,e){if(s===void 0)return e;let[t,r]=[Math.min(s[0],e[0]),Math.min(s[1],e[1])],[n,o]=[Math.max(s[0]+s[2],e[0]+e[2]),Math.max(s[1]+s[3],e[1]+e[3])];return[t,r,n-t,o-r]}function Co(s,e){let t=s===0?1:0,r=[...e].sort((o,i)=>o[t]-i[t]||o[s]-i[s]),n=[];for(let o of r){let i=n.at(-1);i!==void 0&&i[t]===o[t]&&i[t+2]===o[t+2]&&i[s]+i[s+2]===o[s]?i[s+2]+=o[s+2]:n.push([...o])}return n}function No(s){return Co(1,Co(0,s))}function*be(s,e){let{width:t,unitWidth:r,unitHeight:n}=s,[o,i,a,c]=e,u=Math.ceil(t/r);for(let l=Math.floor(i/n);l*n<i+c;l+=1)for(let d=Math.floor(o/r);d*r<o+a;d+=1){let f=Bu(R(s,l*u+d),e);f!==void 0&&(yield[l*u+d,f])}}var vt=class{constructor(e){this.stream=e;this.#e=new Uint8Array(L(e))}stream;#e;isKnown(e){return this.#e[e]===1}setKnown(e,t){let r=this.#e[e];return this.#e[e]=Number(t),r!==Number(t)}},we=class{constructor(e){this.streams=e;this.depth=new vt(e.depth),this.others=[e.color,e.alpha,e.material].filter(t=>t!==void 0).map(t=>new vt(t))}streams;depth;others;#e=new Set;#t=[];#r=new Set;setKnown(e,t,r){let n=e.setKnown(t,r);e===this.depth&&r?this.#e.add(t):n&&this.#t.push(R(e.stream,t))}setMaterial(e,t){this.#r.delete(e),t.some((r,n)=>r>0&&n%3<2)&&this.#r.add(e)}isSpecular(e){let{material:t}=this.streams;return t!==void 0&&[...this.#r].some(r=>e(t,r))}takeParts(){let e=new Map;for(let t of this.#e)e.set(t,[R(this.streams.depth,t)]);for(let t of this.#t)for(let[r,n]of be(this.depth.stream,t))this.#e.has(r)||e.set(r,[...e.get(r)??[],n]);return this.#e.clear(),this.#t=[],[...e].flatMap(([t,r])=>this.#n(t,r))}#n(e,t){let r=t.map(o=>({rect:o,isKnown:this.depth.isKnown(e)}));for(let o of this.others)r=r.flatMap(({rect:i,isKnown:a})=>[...be(o.stream,i)].map(([c,u])=>({rect:u,isKnown:a&&o.isKnown(c)})));let n=[...new Map(r.map(o=>[o.rect.join(),o])).values()];return[!0,!1].flatMap(o=>{let i=n.filter(a=>a.isKnown===o).map(({rect:a})=>a);return No(i).map(a=>({rect:a,tile:e,isKnown:o}))})}},ge=class{#e=new Map;#t=new Map;load(e,t){this.#e.set(e,t);for(let r of t)[r.depth,...r.others].forEach(n=>this.#t.set(n.stream.index,{face:r,units:n}))}unload(e){let t=this.ofView(e);for(let{depth:r,others:n}of t)[r,...n].forEach(({stream:o})=>this.#t.delete(o.index));return this.#e.delete(e),t}views(){return this.#e.entries()}ofView(e){let t=this.#e.get(e);if(t===void 0)throw new Error(`View ${e} is not loaded`);return t}isSpecular(e,t){return this.#e.get(e)?.some(r=>r.isSpecular(t))??!1}ofStream(e){let t=this.#t.get(e);if(t===void 0)throw new Error(`Stream ${e} is of no loaded view`);return t}isKnown(e,t){return this.ofStream(e).units.isKnown(t)}setKnown(e,t,r){let{face:n,units:o}=this.ofStream(e);n.setKnown(o,t,r)}};var Lr=class extends we{constructor(t,r,n){super(t);this.view=r;this.codes=n}view;codes},xt=class{constructor(e,t){this.catalogue=e;this.send=t}catalogue;send;#e=new ge;load(e,t){let{faces:r,nearM:n,farM:o}=this.catalogue.views[e];this.#e.load(e,r.map(a=>new Lr(a,e,t)));let i=r.flatMap(({face:a,size:c,map:u,header:{range:l,isDistance:d},alpha:f,material:m})=>{let h=[d,f!==void 0,m!==void 0].map(Number);return[a,...c,...u.scale,...u.center,l.nearM,l.farM,...h]});this.send({kind:"load",view:e,numbers:Float64Array.of(n,o,...i)})}unload(e){this.#e.unload(e),this.send({kind:"unload",view:e})}isKnown(e,t){return this.#e.isKnown(e,t)}written(e,t){this.#e.setKnown(e,t,!0)}forget(e,t){this.#e.setKnown(e,t,!1)}uploadColor(e,t,r){let{view:n,streams:o}=this.#e.ofStream(e).face;this.send({kind:"color",area:{view:n,face:o.face,rect:t},texels:r})}uploadMaterial(e,t,r){let{face:n,units:o}=this.#e.ofStream(e);n.setMaterial(t,r);let i={view:n.view,face:n.streams.face,rect:R(o.stream,t)};this.send({kind:"material",area:i,texels:r}),this.written(e,t)}isSpecular(e,t){return this.#e.isSpecular(e,t)}update(){for(let[e,t]of this.#e.views())for(let r of t){let{depth:n,face:o}=r.streams;for(let{rect:i,tile:a,isKnown:c}of r.takeParts()){let u=c?Du(r.codes(n.index,a),R(n,a),i):void 0;this.send({kind:"depth",area:{view:e,face:o,rect:i},codes:u})}}}};function Du(s,[e,t,r],n){let o=new Uint16Array(n[2]*n[3]);for(let i=0;i<n[3];i+=1){let a=(n[1]-t+i)*r+n[0]-e;o.set(s.subarray(a,a+n[2]),i*n[2])}return o}var Hu=320*180,Gu=128,kt=class{constructor(e){this.scene=e;this.#e=He("cpu_worker.js",import.meta.url),this.#e.onmessage=({data:n})=>{this.#r?.resolve(n),this.#r=void 0},this.#e.onerror=({message:n})=>this.#o(n??"it did not load"),this.#e.onmessageerror=()=>this.#o("its answer cannot be read");let t={module:Te(),coding:e.catalogue.coding};this.#e.postMessage(t);let r=n=>this.#e.postMessage(n);this.texels=new xt(e.catalogue,r),this.#t=new pe(e.container,e.catalogue,(n,o,i)=>{r({kind:"overlay",area:{...n,rect:o},texels:i})})}scene;texels;name="cpu";mostPixels=Hu;hasEffects=!0;onFailed=()=>{};#e;#t;#r;#n;#s={size:[0,0],rgba:new Float32Array};load(e,t,r){return this.#t.forget(e),this.texels.load(e,(n,o)=>r(n,o)),Promise.resolve([])}async draw(e,t){let{view:r,cameras:n}=e,o=[];for(let f of n)o.push(await this.#a(e,f,!1));let i=Ue(e),a=yt(r),c;a.length>0&&(this.#t.paint(a,e),c=(await this.#a(e,n[0],!0)).rgba);let u=o.map(({rgba:f})=>f);this.#s={size:i,rgba:u[0]};let l={...r,marksHoles:r.overlays.has("holes"),overlayShare:gt};Mo(this.scene.canvas,i,{eyes:u,overlay:c},l),t();let[{counts:d}]=o;return{counters:{...d},decodeMs:0,marchMs:o.reduce((f,{ms:m})=>f+m,0)}}decodeMs(){return Promise.resolve(0)}pixels(){return Promise.resolve(this.#s)}close(){this.#e.terminate(),this.#i("The film was closed.")}#o(e){let t=`The worker that renders failed: ${e}`;this.#i(t),this.onFailed(t)}#i(e){this.#n??=e,this.#r?.reject(new Error(e)),this.#r=void 0}#a(e,t,r){let{container:n,catalogue:o}=this.scene,{view:i,views:a}=e,c={kind:"render",request:{camera:t,size:Ue(e),steps:Math.min(i.steps,Gu),showsOverlay:r,marksHoles:i.overlays.has("holes")},views:a.map(u=>{let{position:l,orientation:d}=n.probeAt(o.views[u].probe,i.frame);return{view:u,position:l,orientation:d}})};return new Promise((u,l)=>{if(this.#n!==void 0)throw new Error(this.#n);this.#r?.reject(new Error("Another picture was ordered.")),this.#r={resolve:u,reject:l},this.#e.postMessage(c)})}};var zu={bc1:"cells-bc1",bc7:"cells-bc7",bc6h:"cells-bc6h"};function Wu(s){switch(s.kind){case"alpha":throw new y("Alpha is not decoded on the graphics device.");case"material":return s.inBlocks?"boxes-bc1":"boxes-material";case"depth":switch(s.coding.name){case"boxes":return s.coding.inBlocks?"boxes-bc5":"boxes-codes";case"predictive":return"boxes-codes";default:return"nodes"}case"color":return s.coding.name==="transform"?s.isHalf?"transform-half":"transform-8bit":s.coding.blocks!==void 0?zu[s.coding.blocks]:s.isHalf?"cells-half":"cells-8bit"}}function ye(s){let e=Wu(s);if(s.kind!=="color")return{kernel:e,keyframes:void 0,plan:"plan-records",words:s.kind==="material"?"bytes":"codes",isColor:!1};let t=s.isHalf?"cells-half":"cells-8bit";return{kernel:e,keyframes:s.coding.name==="transform"?t:void 0,plan:"plan-cells",words:s.isHalf?"halves":"bytes",isColor:!0}}function Et(s,e,t){switch(s.words){case"codes":return Math.ceil(e/2);case"halves":return 2*e;case"bytes":return s.isColor?Math.ceil(e/t)*t:e}}function Oo(s,e){let t=ye(s.header),r=Math.min(s.unitWidth,s.width);return(Math.floor(s.width/r)*Et(t,r,e)+Et(t,s.width%r,e))*s.height}function Fo(s){let e={window:0,domain:0,base:0,scale:0};if(s.kind==="material")return{...e,window:s.window};if(s.kind!=="depth")return e;let{coding:t}=s;switch(t.name){case"boxes":return{...e,window:t.window};case"predictive":return{...e,window:1};case"nodes":return{window:t.window,domain:t.domain.kind,base:t.domain.base,scale:t.domain.scale};case"blocks":return e}}var I=Ne.constants,St=2,ju={u32:["u32",1,1],i32:["i32",1,1],f32:["f32",1,1],"vec2<f32>":["f32",2,2],"vec3<f32>":["f32",3,4],"array<u32, 8>":["u32",8,1]};function Vu(s){let e=new Map,[t,r]=[0,1];for(let n of s){let[o="",i=""]=n.split(": "),a=ju[i];if(a===void 0)throw new Error(`shaders/kernels.json: ${i} is no type of a member`);let[c,u,l]=a,d=Math.ceil(t/l)*l;e.set(o,{scalar:c,offset:d,words:u}),t=d+u,r=Math.max(r,l)}return{members:e,words:Math.ceil(t/r)*r}}var $u=new Map(Ne.structs.map(s=>[s.name,Vu(s.members)]));function Uo(s){let e=$u.get(s);if(e===void 0)throw new Error(`shaders/kernels.json has no struct ${s}`);return e}function Lo(s,e){let t=Uo(s).members.get(e);if(t===void 0)throw new Error(`shaders/kernels.json: ${s} has no member ${e}`);return t}function B(s){return Uo(s).words}function T(s,e){return Lo(s,e).offset}function Le(s,e,t,r){for(let[n,o]of Object.entries(r)){let{scalar:i,offset:a,words:c}=Lo(t,n),u=typeof o=="number"?[o]:o;if(u.length!==c)throw new Error(`${t}.${n} has ${c} words and not ${u.length}`);i==="f32"?new Float32Array(s.buffer,s.byteOffset,s.length).set(u,e+a):s.set(u,e+a)}}function Y(s,e){let t=B(s),r=new Uint32Array(e.length*t);return e.forEach((n,o)=>Le(r,o*t,s,n)),r}function Rt(s,e){let t=new Uint32Array(St+e.length);return t.set(s),t.set(e,St),t}var Ku=16384,_e=class{label;buffer;bytesSent=0;#e;#t=0;#r=[];#n=0;constructor(e,t){this.#e=e,this.label=t,this.buffer=e.buffer(t,Ku)}get taken(){return this.#t-this.#n}hasRoom(e,t){return this.#r.some(r=>r.words>=e)||this.#t+e<=t}put(e){let t=this.#s(e.length);return this.#e.write(this.buffer,4*t,e),this.bytesSent+=e.byteLength,t}#s(e){let t;for(let n of this.#r)n.words>=e&&(t===void 0||n.words<t.words)&&(t=n);if(t!==void 0&&e>0){let{at:n}=t;return t.at+=e,t.words-=e,this.#n-=e,this.#r=this.#r.filter(o=>o.words>0),n}let r=this.#t;return this.#o(r+e),this.#t=r+e,r}#o(e){let t=this.buffer;if(4*e<=t.size)return;let r=Math.floor(this.#e.maxBindingBytes/4),n=Math.max(Math.min(2**Math.ceil(Math.log2(e)),r),e);this.buffer=this.#e.buffer(this.label,n),this.#e.submit(o=>o.copyBufferToBuffer(t,0,this.buffer,0,t.size)),this.#e.release(t)}free({at:e,words:t}){if(t===0)return;let r=this.#r.findIndex(l=>l.at>e),n=r<0?this.#r.length:r,[o,i]=[this.#r[n-1],this.#r[n]],a={at:e,words:t},[c,u]=[n,0];o!==void 0&&o.at+o.words===e&&(a.at=o.at,a.words+=o.words,c-=1,u+=1),i!==void 0&&i.at===e+t&&(a.words+=i.words,u+=1),this.#r.splice(c,u,a),this.#n+=t,a.at+a.words===this.#t&&(this.#r.pop(),this.#n-=a.words,this.#t=a.at)}destroy(){this.#e.release(this.buffer)}},re={words:B("Record"),at:T("Record","at"),first:T("Record","first"),work:T("Record","work")},Ir={words:B("BoxRow"),at:T("BoxRow","at")},Mt=B("Chunk"),Br=4;function Bo(s){return Math.ceil(s.length/Br)*Br}function qu(s){if(s.length%Br===0)return s;let e=new Uint32Array(Bo(s));return e.set(s),e}function Io(s,e,t){let r=s.slice();for(let[n,o]of t)for(let i=n;i<r.length;i+=e)r[i]+=o;return r}var Tt=class{#e;#t;#r;#n;#s=new Map;#o;constructor(e,t){this.#e=new _e(e,"stream"),this.#t=new _e(e,"records"),this.#r=new _e(e,"boxes"),this.#n=new _e(e,"chunks"),this.#o=t}get#i(){return[this.#e,this.#t,this.#r,this.#n]}buffer(e){return this.#i.find(t=>t.label===e)?.buffer}chunk(e){return this.#s.get(e)}get streamWords(){return this.#e.taken}get bytes(){return this.#i.reduce((e,t)=>e+t.buffer.size,0)}get bytesSent(){return this.#i.reduce((e,t)=>e+t.bytesSent,0)}hasRoom({stream:e,records:t,boxes:r}){let n=[Bo(e),t.length,r.length,Mt];return this.#i.every((o,i)=>o.hasRoom(n[i]??0,this.#o))}place(e,t,r){let n=qu(t.stream),o=this.#e.put(n),i=Io(t.boxes,Ir.words,[[Ir.at,4*o]]),a=this.#r.put(i),c=Io(t.records,re.words,[[re.at,t.isNodes?o:4*o],[re.first,a/Ir.words]]),u=this.#t.put(c),[l,d]=t.weights,f=new Uint32Array(Mt);Le(f,0,"Chunk",{first_record:u/re.words,record_count:c.length/re.words,weights_at:l+4*o,weight_count:d});let m=this.#n.put(f),h=0;for(let b=re.work;b<c.length;b+=re.words)h=Math.max(h,c[b]??0);this.#s.set(e,{row:m/Mt,mostWork:h,kernel:t.kernel,passes:t.passes,timeline:t.timeline,lastUsed:r,places:[{at:o,words:n.length},{at:u,words:c.length},{at:a,words:i.length},{at:m,words:Mt}]})}drop(e,t){let r=[...this.#s].filter(([n])=>!e.has(n));r.sort(([n,{lastUsed:o}],[i,{lastUsed:a}])=>o-a||n-i);for(let[n,{places:o}]of r){if(this.streamWords<=t)return;this.#s.delete(n),this.#i.forEach((i,a)=>i.free(o[a]??{at:0,words:0}))}}destroy(){this.#i.forEach(e=>e.destroy()),this.#s.clear()}};function Do(s,e,t,r){if(e===t)return[];if(r===0)return[Dr(s,t)-1];let n=e===void 0||e>t,o=n?[0]:[],i=n?0:e;for(;i<t;){let a=Dr(s,i),c=Math.min(a<s.length?s[a]:t,t);i+=Math.floor((c-i-1)/r)*r,i+=Math.min(r,t-i);let u=Dr(s,i)-1;s[u]===i&&o.push(u)}return o}function Dr(s,e){let t=0,r=s.length;for(;t<r;){let n=t+r>>>1;s[n]<=e?t=n+1:r=n}return t}function At(s,e){let{keyframes:t,weights:r}=s,[n,o]=[0,t.length];for(;n<o;){let c=n+o>>1;t[c]<=e?n=c+1:o=c}let i=Math.max(n-1,0),a=e<r.length?r[e]:0;return{keyframe:i,weight:a,needsNext:a>0&&i+1===t.length}}function Hr(s,e,t,r){if(t===void 0)return r;let{frameSets:n,framePixels:o}=s;if(o.length===0){let[c,u]=[At(s,t),At(s,e)];return c.keyframe===u.keyframe&&c.weight===u.weight?0:r}let i=(c,u)=>(n[4*c+(u>>5)]>>>(u&31)&1)===1,a=0;for(let c=0;c<o.length;c++)i(c,e)&&!i(c,t)&&(a+=o[c]);return a}var Xu=64,Yu=16384,Ju=2**31,Qu=2**27,W={words:B("Unit"),picture:T("Unit","picture"),width:T("Unit","width"),height:T("Unit","height"),stride:T("Unit","stride"),window:T("Unit","window")};function Zu(s,e,t,r){let n=[],o=new Uint32Array(s.reduce((c,u)=>c+L(u),0)*W.words),[i,a]=[0,0];return s.forEach((c,u)=>{n.push(i);let l=Fo(c.header),d=t[u]??l.base;for(let f=0;f<L(c);f+=1){let[,,m,h]=R(c,f),b=Et(e,m,r);Le(o,i*W.words,"Unit",{...l,base:d,picture:a,width:m,height:h,stride:b}),a+=b*h,i+=1}}),{firstUnits:n,rows:o}}function el(s,e){return s.reduce((t,r)=>t+Oo(r,e),0)}function tl(s,{reader:e}){let t=s.map(({width:r,height:n,unitWidth:o,unitHeight:i})=>Math.ceil(Math.min(o,r)/32)*Math.ceil(Math.min(i,n)/32));return e===void 0?0:Math.max(0,...t)*I.SCRATCH_WORDS}function rl(s){let e=s.filter(({header:n})=>n.kind==="color"&&n.coding.name==="transform");if(e.length===0)return{words:new Uint32Array,firstSets:[]};let t=e.map(n=>k().openStream(n,n.headerBytes)),r=k().transformTables(t);return t.forEach(n=>k().closeStream(n)),r}var Pt=class s{streams;family;pictures;pixelsWritten=0;pixelsWanted=0;#e;#t;#r;#n;#s=new Map;#o;#i;#a;#l;#m=0;#f=0;constructor(e,t,r,n,o){let i=ye(t[0].header),a=rl(t),c=el(t,o),u=t.reduce((l,d)=>l+L(d),0);e.check("pictures",c),e.check("scratch",tl(t,n.codec)),e.check("units",u*W.words),this.#e=e,this.streams=t,this.family=i,this.#t=r,this.#r=n,this.#n=Zu(t,i,a.firstSets,o),this.pictures=e.buffer("pictures",c),this.#i={units:e.filled("units",this.#n.rows),states:e.buffer("states",u*B("State")),log2_table:e.filled("log2_table",k().log2Table()),tables:e.filled("tables",a.words),dispatch:e.buffer("dispatch",B("Dispatch"),GPUBufferUsage.INDIRECT)},this.#a=e.buffer("items",0),this.#l=e.buffer("jobs",0),this.#o=new Tt(e,Math.floor(e.maxBindingBytes/4))}static async create(e,t,r=1){let[n,...o]=t.map(l=>ye(l.header));if(n===void 0||o.some(({kernel:l})=>l!==n.kernel))throw new O("Streams of different families cannot be decoded together.");let i=async l=>{let{reader:d}=fe(l),[f,m]=await Promise.all([e.pipeline(l),d===void 0?void 0:e.pipeline(d)]);return{kernel:f,reader:m}},[a,c,u]=await Promise.all([e.pipeline(n.plan),i(n.kernel),i(n.keyframes??n.kernel)]);return new s(e,t,a,{codec:c,keyframes:u},r)}has(e){return this.#o.chunk(e)!==void 0}add(e,t){return this.has(e)?!0:this.#o.hasRoom(t)?(this.#o.place(e,t,this.#f),!0):!1}drop(e,t){this.#o.drop(e,t)}get chunkWords(){return this.#o.streamWords}get bytes(){let e=[this.pictures,this.#a,this.#l,...Object.values(this.#i)];return this.#o.bytes+e.reduce((t,r)=>t+r.size,0)}get bytesSent(){return this.#o.bytesSent+this.#m}needsNext({key:e,frame:t,firstFrame:r}){let n=this.#o.chunk(e);return this.family.isColor&&n!==void 0&&At(n.timeline,t-r).needsNext}shows(e){let t=this.#s.get(this.#p(e.stream,e.unit));if(t?.key!==e.key)return!1;let r=e.frame-e.firstFrame;return t.frame===r||this.family.isColor&&Hr(t.timeline,r,t.frame,1)===0}showsAny(e,t){return this.#s.has(this.#p(e,t))}unit(e,t){let r=this.#p(e,t)*W.words,n=o=>this.#n.rows[r+o]??0;return{picture:n(W.picture),stride:n(W.stride),width:n(W.width),height:n(W.height)}}decode(e,t){this.#f+=1;let r={written:[],pixels:0,missing:[],behind:[],refused:[]},n=[];for(let o of e){let{width:i,height:a}=this.unit(o.stream,o.unit);this.pixelsWanted+=i*a,this.#d(o,n,r)}return this.pixelsWritten+=r.pixels,n.forEach(o=>this.#b(o,t)),r}destroy(){this.#o.destroy(),[this.pictures,this.#a,this.#l,...Object.values(this.#i)].forEach(e=>this.#e.release(e))}#p(e,t){return(this.#n.firstUnits[e]??0)+t}#d(e,t,r){let n=this.#p(e.stream,e.unit),o=e.frame-e.firstFrame,i=this.#s.get(n);if(i?.key===e.key&&i.frame===o)return;let a=this.#o.chunk(e.key),c=this.needsNext(e)?this.#o.chunk(e.nextKey??0):a;if(a===void 0||c===void 0){r.missing.push(e);return}a.lastUsed=this.#f,c.lastUsed=this.#f;let u=this.#u(e,a.timeline);if(u===void 0){r.refused.push(e);return}let l=t.findLast(({kernel:d})=>d===a.kernel);(l===void 0||l.work+a.mostWork>this.#c(a.kernel))&&(l={kernel:a.kernel,items:[],rounds:0,passes:0,work:0},t.push(l)),l.items.push({unit:n,chunk:a.row,next:c===a?I.NONE:c.row,frame:o,key:e.key}),l.work+=a.mostWork,l.rounds=Math.max(l.rounds,u.rounds),l.passes=Math.max(l.passes,a.passes),this.#s.set(n,{key:e.key,frame:u.reached,timeline:a.timeline}),r.pixels+=u.pixels,r.written.push({wanted:e,pixels:u.pixels}),u.reached!==o&&r.behind.push(e)}#c(e){return this.#r[e].reader===void 0?Ju:Math.floor(Math.min(Qu,this.#e.maxBindingBytes)/(4*I.SCRATCH_WORDS))}#u(e,t){let r=this.#p(e.stream,e.unit),n=this.#s.get(r),o=n?.key===e.key?n.frame:void 0,i=e.frame-e.firstFrame,{width:a,height:c}=this.unit(e.stream,e.unit),u=a*c;if(this.family.isColor)return{rounds:1,pixels:Hr(t,i,o,u),reached:i};let l=this.#n.rows[r*W.words+W.window]??0;if(l===0)return{rounds:1,pixels:u,reached:i};let d=Do(t.recordFrames,o,i,l);if(d.length>Yu)return;let f=d.slice(0,Xu),m=f.at(-1),h=f.length<d.length&&m!==void 0;return{rounds:Math.max(f.length,1),pixels:f.reduce((b,w)=>b+(t.recordPixels[w]??0),0),reached:h?t.recordFrames[m]??i:i}}#b({kernel:e,items:t,rounds:r,passes:n,work:o},i){let a=Rt([t.length,0],Y("Item",t));this.#a=this.#h(this.#a,a.length),this.#l=this.#h(this.#l,St+t.length*B("Job")),this.#e.write(this.#a,0,a),this.#m+=a.byteLength;let{reader:c,kernel:u}=this.#r[e];c!==void 0&&this.#e.scratch(o*I.SCRATCH_WORDS);let[l,d]=[0,4*T("Dispatch","part_x")],f=[...c===void 0?[]:[{...c,times:n,size:l}],{...u,times:1,size:c===void 0?l:d}].map(h=>({...h,group:this.#g(h)})),m=this.#g(this.#t);this.#e.submit(h=>{let b=h.beginComputePass(i===void 0?{}:{timestampWrites:i});for(let w=0;w<r;w+=1){b.setPipeline(this.#t.pipeline),b.setBindGroup(0,m),b.dispatchWorkgroups(1);for(let{pipeline:_,group:v,times:x,size:P}of f){b.setPipeline(_),b.setBindGroup(0,v);for(let F=0;F<x;F+=1)b.dispatchWorkgroupsIndirect(this.#i.dispatch,P)}}b.end()})}#h(e,t){if(4*t<=e.size)return e;let r=this.#e.buffer(e.label,t);return this.#e.release(e),r}#g(e){let t={...this.#i,items:this.#a,jobs:this.#l,scratch:this.#e.scratch(0),pictures:this.pictures};return this.#e.bind(e,r=>{let n=t[r]??this.#o.buffer(r);if(n===void 0)throw new O(`No buffer of a decoder is named ${r}.`);return{buffer:n}})}};var ve=64,Ho=2139095040,Go=1900671690,nl=64,sl=[[0,6],[8,3],[11,2],[13,1]],Wr=13,zo=[0,1,2,3,4,5],Ct=class{#e=new Map;of(e){let t=`${e.nearM} ${e.farM}`,r=this.#e.get(t)??k().inverseDepths(e);return this.#e.set(t,r),r}};function ol(s,e,t){let r=e,n=[s.size,...dt(s.size)].map(l=>{let d={at:r,pitch:Math.ceil(l[0]/ve)*ve,size:l};return r+=d.pitch*l[1],d});n[n.length-1].at=s.face;let{header:o,size:i,map:a}=s,c=t.add(`${o.range.nearM} ${o.range.farM}`,()=>t.depths.of(o.range)),u=o.isDistance?t.add([...i,...a.scale,...a.center].join(),()=>il(s)):I.NONE;return{planes:{levels:n,table:c,rayLengths:u},end:r}}function il({size:[s,e],map:t}){let r=new Float32Array(s*e);for(let n=0;n<e;n+=1)for(let o=0;o<s;o+=1)r[n*s+o]=ht(t,o,n);return new Uint32Array(r.buffer)}var Gr=class{constructor(e){this.depths=e}depths;parts=[];words=0;#e=new Map;add(e,t){let r=this.#e.get(e);if(r!==void 0)return r;let n=this.words,o=t();return this.parts.push(o),this.words+=o.length,this.#e.set(e,n),n}all(){let e=new Uint32Array(this.words),t=0;for(let r of this.parts)e.set(r,t),t+=r.length;return e}};function Wo(s,e,[t,r,n,o],i){return{below:s.at,below_pitch:s.pitch,below_width:s.size[0],below_height:s.size[1],left:t,top:r,width:n,output:e.at,pitch:e.pitch,limit:I.NONE,end:i+n*o}}var zr=class{steps=[];#e=[];#t=0;add(e,t,r,n){let o=r.at(-1)?.end??0;if(o>0){let i=Rt([o,r.length],Y(t,r));this.steps.push({kernel:e,pictures:n,at:this.#t,words:i.length,invocations:o}),this.#e.push(i),this.#t+=Math.ceil(i.length/ve)*ve}}all(){let e=new Uint32Array(this.#t);return this.steps.forEach(({at:t},r)=>e.set(this.#e[r],t)),e}},Nt=class{constructor(e,t,r,n){this.gpu=e;this.kernels=t;let o=new Gr(n),i=nl;for(let c of r){let{planes:u,end:l}=ol(c,i,o);this.#t.set(c.face,u),i=l}e.check("planes",i),e.check("tables",o.words);let a=new Uint32Array(i).fill(Ho);a[Wr]=Go,this.planes=e.filled("planes",a),this.#e=e.filled("tables",o.all()),this.#r=e.buffer("jobs",0),this.hasGreatest=this.#t.size===zo.length&&zo.every(c=>this.#t.has(c))}gpu;kernels;planes;hasGreatest;#e;#t=new Map;#r;get bytes(){return this.planes.size+this.#e.size+this.#r.size}levels(e){return this.#t.get(e)?.levels??[]}write(e){let t=new zr,r=new Map;for(let{pictures:n,parts:o}of e){let i=0,a=o.map(c=>(i+=c.rect[2]*c.rect[3],r.set(c.face,_t(r.get(c.face),c.rect)),{...this.#n(c),end:i}));t.add("texels","DepthJob",a,n)}return this.#s(r,t),t.steps.length>0&&this.#o(t),r}destroy(){[this.planes,this.#e,this.#r].forEach(e=>this.gpu.release(e))}#n({face:e,rect:[t,r,n],picture:o,corner:i}){let{levels:a,table:c,rayLengths:u}=this.#t.get(e),[{at:l,pitch:d,size:f}]=a,m={width:n,output:l+r*d+t,pitch:d};return o===void 0?{...m,picture:I.NONE,table:Ho,ray_length:I.NONE}:{...m,picture:o.picture,stride:o.stride,left:t-i[0],top:r-i[1],table:c,ray_length:u===I.NONE?u:u+r*f[0]+t,ray_length_pitch:f[0]}}#s(e,t){let r=Math.max(0,...[...e.keys()].map(n=>this.levels(n).length));for(let n=1;n<r;n+=1){let o=[];for(let[i,a]of e){let[c,u]=this.levels(i).slice(n-1,n+1);u!==void 0&&o.push(Wo(c,u,ft(a,n-1),o.at(-1)?.end??0))}t.add("squares","PyramidJob",o)}if(this.hasGreatest&&e.size>0){let n=sl.map(([o,i])=>({at:o,pitch:i,size:[i,1]}));for(let o=1;o<n.length;o+=1){let i=Wo(n[o-1],n[o],[0,0,n[o].size[0],1],0);t.add("squares","PyramidJob",[{...i,limit:Go}])}}}#o(e){let t=e.all();this.#r.size<4*t.length&&(this.gpu.release(this.#r),this.#r=this.gpu.buffer("jobs",t.length)),this.gpu.write(this.#r,0,t),this.gpu.submit(r=>{let n=r.beginComputePass({label:"planes"});for(let o of e.steps){let i=this.kernels[o.kernel],c={jobs:{buffer:this.#r,offset:4*o.at,size:4*o.words},tables:{buffer:this.#e},planes:{buffer:this.planes},...o.pictures&&{pictures:{buffer:o.pictures}}};n.setPipeline(i.pipeline),n.setBindGroup(0,this.gpu.bind(i,d=>c[d]));let u=Math.ceil(o.invocations/fe(o.kernel).workgroup),l=Math.min(u,I.MAX_GROUPS);n.dispatchWorkgroups(l,Math.ceil(u/l))}n.end()})}};var al=.01,jo=.1,Vo=1e-18;function cl({orientation:s}){let e=mn(We(s)??[0,0,0,1]);return[je(e,[1,0,0]),je(e,[0,1,0]),je(e,[0,0,1])]}function ul({faces:s}){let e=s.flatMap(({size:[t,r],map:n})=>[0,t-1].flatMap(o=>[0,r-1].map(i=>ht(n,o,i))));return Math.max(1,...e)}function $o({views:s,coding:e},t,r,n){let o=u=>[Math.fround(u[0]),Math.fround(u[1]),Math.fround(u[2])],i=t.map(u=>{let l=s[u],d=n(l.probe);return{view:u,streams:l,fromEye:o(Z(d.position,r)),turn:cl(d),cameraWeight:1}}),a=i.map(({fromEye:u})=>q(u)),c=Math.max(0,...a);return c>0&&i.forEach((u,l)=>u.cameraWeight=1/(a[l]/c+al)),{views:i,coding:e,nearest:a.indexOf(Math.min(...a)),nearM:Math.min(...i.map(({streams:u})=>u.nearM)),farM:Math.max(...i.map(({streams:u},l)=>a[l]+u.farM*ul(u)))}}function Ko({distancesM:s}){let e=2**Math.ceil(Math.log2(s.length));return{longest:e,first:Math.max(e/4,1)}}var Ie=["primary_rays","march_steps","refine_steps","secondary_rays","normal_evals","material_samples","hole_rays","background_rays"];var Xo={steps:1024,refine:8,samples:1,holes:"behind",maxBounces:4,effects:!0},ll=1e30,dl=(2-2**-23)*2**127,fl=4294967295,ml=8,hl=8,qo={light:0,srgb:1,linear:2},pl={blank:0,nearest:1,behind:2},bl=7,wl=0;function gl(s){return s.name==="light"?{coding:qo.light,gain:1}:{coding:qo[s.transfer],gain:2**-s.exposureEv}}function yl(s,e,t){let{texels:r,pyramid:n,layer:o}=t.origin(e,s.face);return{column:r[0],row:r[1],layer:o,has_material:+(s.material!==void 0),width:s.size[0],height:s.size[1],pyramid_column:n[0],pyramid_row:n[1],levels:dt(s.size).length,number:s.face,scale:s.map.scale,centre:s.map.center,has_alpha:+(s.alpha!==void 0)}}function _l({coding:s,views:e,nearest:t},{axes:[r,n,o],half:i},a,c){let u=a.distancesM.length,l=Ko(a);return{forward:r,right:N(n,i[0]),down:N(o,i[1]),samples:c.samples,view_count:e.length,distance_count:u,refine:c.refine,tolerance:jo+a.uncertainty,holes:pl[c.holes],...gl(s),max_bounces:Math.min(c.maxBounces,hl),longest_segment:l.longest,first_segment:l.first,near_m:0,far_m:dl,log_step:a.logStep,nearest_view:t,refinements:bl,background:wl}}function Yo(s,e,[t,r],n,o){let i=k().raySteps(n.steps,s.nearM/10,s.farM,n.refine),a=[],c=s.views.map(({view:l,streams:d,fromEye:f,turn:m,cameraWeight:h})=>{let b=new Array(ml).fill(fl);for(let x of d.faces)b[x.face]=a.length,a.push(yl(x,l,o));let[w,_,v]=m;return{from_eye:f,near_m:d.nearM,turn_x:w,camera_weight:h,turn_y:_,greatest_inverse_depth:ll,turn_z:v,faces:b}}),u={width:t,height:r,pyramid_rows:o.arrays.pyramidRows};return{scene:Y("Scene",[{..._l(s,e,i,n),...u}]),views:Y("View",c),faces:Y("Face",a),distancesM:new Uint32Array(i.distancesM.buffer)}}var xe=8,vl=-1,xl=2**28,kl=256,El=50;function Jo([s,e]){return Math.ceil(s/xe)*Math.ceil(e/xe)*Ie.length}function Sl(s){let e=r=>Math.min(kl,4**r),t=0;for(let r=0;r<s;r+=1)t+=3*e(r)+e(r+1);return t}function Qo(s,e,t,r){let n=t.steps+1+t.refine,o=t.samples**2*s*n*e*(1+r);return Math.max(Math.floor(xl/(o*xe)),1)*xe}var ke=class{constructor(e){this.gpu=e;this.#e=e.buffer("pixels",0),this.#t=e.buffer("counts",0)}gpu;size=[0,0];#e;#t;get pixels(){return this.#e}get counts(){return this.#t}resize([e,t]){e===this.size[0]&&t===this.size[1]||(this.gpu.check("pixels",4*e*t),this.destroy(),this.#e=this.gpu.buffer("pixels",4*e*t),this.#t=this.gpu.buffer("counts",Jo([e,t])),this.size=[e,t])}async readPixels(){let e=await this.gpu.read(this.#e,0,4*this.size[0]*this.size[1]),t=new Float32Array(e.buffer);for(let r=3;r<t.length;r+=4)if(t[r]===vl)throw new O("The graphics device ended loops before they were done; take fewer steps.");return t}async readCounters(){let e=await this.gpu.read(this.#t,0,Jo(this.size)),t=new Array(Ie.length).fill(0);return e.forEach((r,n)=>t[n%Ie.length]+=r),Object.fromEntries(Ie.map((r,n)=>[r,t[n]]))}destroy(){this.gpu.release(this.#e),this.gpu.release(this.#t)}},Ot=class{constructor(e,t){this.gpu=e;this.texels=t}gpu;texels;#e=new Map;async render(e,t){let{active:r,camera:n,size:o,settings:i}=t,a=i.effects&&r.views.some(({view:w})=>this.texels.isSpecular(w,()=>!0)),c=await this.gpu.pipeline(a?"render-effects":"render-pyramid");e.resize(o),this.#t(Yo(r,n,o,i,this.texels)),this.#r(r);let u=this.#n(c,e,t.colors),[l,d]=o,f=Qo(l,r.views.length,i,0),m=a?Sl(i.maxBounces):0,h=Qo(l,r.views.length,i,m),b=h;for(let w=0;w<d;){let _=Math.min(b,d-w),v=performance.now();this.#s({pipeline:c,group:u,width:l,rows:[w,_]},t.timing?.()),w+=_,a&&w<d&&(await this.gpu.queue.onSubmittedWorkDone(),b=performance.now()-v<El?Math.min(2*b,f):h)}}#t({scene:e,views:t,faces:r,distancesM:n}){for(let[o,i]of Object.entries({scene:e,views:t,faces:r,distances_m:n})){let a=this.#e.get(o);(a===void 0||a.size<i.byteLength)&&(a!==void 0&&this.gpu.release(a),a=this.gpu.buffer(o,i.length),this.#e.set(o,a)),this.gpu.write(a,0,i)}}#r({views:e}){let t=this.#e.get("views"),r=T("View","greatest_inverse_depth");this.gpu.submit(n=>{e.forEach(({view:o,streams:i},a)=>{let c=this.texels.planes(o);if(c.hasGreatest&&i.nearM>=Vo){let u=4*(a*B("View")+r);n.copyBufferToBuffer(c.planes,4*Wr,t,u,4)}})})}#n(e,t,r){let n=new Map([...this.#e,["pixels",t.pixels],["counts",t.counts]]);return this.gpu.bind(e,o=>{let i=n.get(o);if(i!==void 0)return{buffer:i};let a=o==="colors"&&r!==void 0?r:this.texels.arrays.view(o);if(a===void 0)throw new O(`No input of rendering is named ${o}.`);return a})}#s(e,t){let{pipeline:r,group:n,width:o,rows:i}=e,a=this.#e.get("scene");["first_row","rows"].forEach((c,u)=>{this.gpu.write(a,4*T("Scene",c),Uint32Array.of(i[u]))}),this.gpu.submit(c=>{let u=c.beginComputePass({label:"render",...t&&{timestampWrites:t}});u.setPipeline(r.pipeline),u.setBindGroup(0,n),u.dispatchWorkgroups(Math.ceil(o/xe),Math.ceil(i[1]/xe)),u.end()})}};var Zo=`// Shows pictures of linear light on a canvas.

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
`;var Ml={TONE_REINHARD:ue.reinhard,TONE_FILMIC:ue.filmic,EYES_SIDE_BY_SIDE:Ze["side-by-side"],EYES_ANAGLYPH:Ze.anaglyph},ei=10,Ft=class s{constructor(e,t,r){this.gpu=e;this.canvas=t;this.#e=r.context,this.#t=r.pipeline;let n=GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST;this.#r=e.device.createBuffer({label:"options",size:4*ei,usage:n})}gpu;canvas;#e;#t;#r;static async create(e,t){let r=t.getContext("webgpu");if(r===null)throw new O("The canvas cannot be drawn to by the graphics device.");let n=navigator.gpu.getPreferredCanvasFormat();r.configure({device:e.device,format:n,alphaMode:"opaque"});let o=e.device.createShaderModule({label:"present",code:Zo}),i=await e.device.createRenderPipelineAsync({label:"present",layout:"auto",vertex:{module:o,entryPoint:"corner"},fragment:{module:o,entryPoint:"show",constants:Ml,targets:[{format:n}]}});return new s(e,t,{context:r,pipeline:i})}show([e,t,r],n){let o=new Uint32Array(ei),i=new Float32Array(o.buffer);i.set([...e.size,this.canvas.width,this.canvas.height,2**n.exposureEv]),o.set([ue[n.toneMap],Ze[n.stereo],Number(n.marksHoles)],5),i[8]=n.overlay,this.gpu.write(this.#r,0,o);let a=[this.#r,e.pixels,t.pixels,r.pixels],c=this.gpu.device.createBindGroup({layout:this.#t.getBindGroupLayout(0),entries:a.map((u,l)=>({binding:l,resource:{buffer:u}}))});this.gpu.submit(u=>{let l=this.#e.getCurrentTexture().createView(),d=u.beginRenderPass({colorAttachments:[{view:l,loadOp:"clear",storeOp:"store"}]});d.setPipeline(this.#t),d.setBindGroup(0,c),d.draw(3),d.end()})}};var jr=class extends we{constructor(t,r,n){super(t);this.tile=r;this.pictures=n;this.copied=[0,0,...t.size]}tile;pictures;staleCells=new Set;copied;get depthPictures(){return this.pictures.get(this.streams.depth.index)}takeDepths(){let{decoder:t,position:r}=this.depthPictures;return this.takeParts().map(({rect:n,tile:o,isKnown:i})=>{let[a,c]=R(this.streams.depth,o),u=i?t.unit(r,o):void 0;return{face:this.streams.face,rect:n,picture:u,corner:[a,c]}})}},Ut=class s{constructor(e,t,r,n){this.gpu=e;this.kernels=t;this.catalogue=r;this.arrays=new mt(e,r,n)}gpu;kernels;catalogue;arrays;#e=new Ct;#t=new Map;#r=new ge;static async create(e,t,r){let[n,o]=await Promise.all([e.pipeline("texels"),e.pipeline("squares")]);return new s(e,{texels:n,squares:o},t,r)}load(e,t){let{faces:r}=this.catalogue.views[e],n=new Nt(this.gpu,this.kernels,r,this.#e),o=r.map(()=>this.arrays.take()),i=r.flatMap((a,c)=>{let u=o[c];return u===void 0?[]:[new jr(a,u,t)]});if(i.length<r.length)throw i.forEach(({tile:a})=>this.arrays.free(a)),n.destroy(),new O("The textures have no room for another probe.");this.#t.set(e,n),this.#r.load(e,i)}unload(e){this.planes(e).destroy(),this.#t.delete(e),this.#r.unload(e).forEach(({tile:t})=>this.arrays.free(t))}get bytes(){return[...this.#t.values()].reduce((e,{bytes:t})=>e+t,0)}isKnown(e,t){return this.#r.isKnown(e,t)}written(e,t){let{face:r}=this.#r.ofStream(e);this.#r.setKnown(e,t,!0),e!==r.streams.depth.index&&r.pictures.has(e)&&r.staleCells.add(t)}forget(e,t){this.#r.setKnown(e,t,!1)}uploadColor(e,t,r){this.arrays.upload("colors",this.#r.ofStream(e).face.tile,t,r)}uploadMaterial(e,t,r){let{face:n,units:o}=this.#r.ofStream(e),i=new Uint8Array(r.length/3*4);for(let a=0,c=0;a<r.length;a+=3,c+=4)i.set([r[a],r[a+1],r[a+2]],c);n.setMaterial(t,r),this.arrays.upload("materials",n.tile,R(o.stream,t),i),this.written(e,t)}isSpecular(e,t){return this.#r.isSpecular(e,t)}update(){let e=this.gpu.device.createCommandEncoder({label:"texels"}),t=!1;for(let[r,n]of this.#r.views()){let o=this.planes(r),i=new Map;for(let c of n){let{pictures:u}=c.depthPictures.decoder,l=i.get(u)??{pictures:u,parts:[]};l.parts.push(...c.takeDepths()),i.set(u,l)}let a=o.write([...i.values()]);for(let c of n){let u=this.#n(e,{planes:o,face:c},a.get(c.streams.face));t||=u}}t&&this.gpu.queue.submit([e.finish()])}origin(e,t){return this.arrays.origin(this.tile(e,t))}tile(e,t){let r=this.#r.ofView(e).find(({streams:n})=>n.face===t);if(r===void 0)throw new Error(`View ${e} has no face ${t}`);return r.tile}planes(e){let t=this.#t.get(e);if(t===void 0)throw new Error(`View ${e} is not loaded`);return t}#n(e,{planes:t,face:r},n){let o=n===void 0?r.copied:_t(r.copied,n);r.copied=void 0,o!==void 0&&this.arrays.copyDepth(e,r.tile,o,{planes:t,face:r.streams.face});let i=o!==void 0||r.staleCells.size>0,{color:a}=r.streams;for(let c of r.staleCells){let{decoder:u,position:l}=r.pictures.get(a.index),{picture:d,stride:f}=u.unit(l,c),m=R(a,c);this.arrays.copyColor(e,r.tile,m,{buffer:u.pictures,at:d,pitch:f})}return r.staleCells.clear(),i}};var Lt=class{constructor(e,t,r,n){this.decoder=e;this.decoding=t;this.keptWords=r;this.timing=n}decoder;decoding;keptWords;timing;#e=[];#t=new Set;#r=new Set;#n=new Set;#s=new Set;#o=!1;units(e){return new Vr(this,e)}shows(e,t){return this.decoder.shows(this.#i(e,t))}#i(e,{unit:t,frame:r,chunk:n,next:o}){let{firstFrame:i}=this.decoding.container.chunks[n];return{stream:e,unit:t,frame:r,key:n+1,firstFrame:i,nextKey:o+1}}ask(e,t,r){let n=this.prepare(e,t,r);return n==="ready"&&this.#e.push(this.#i(e,t)),n}prepare(e,t,r){let{chunk:n,next:o}=t,i=this.#i(e,t);if(this.decoder.shows(i))return"shown";let a=[this.#a(n,r)];return a[0]==="shown"&&o>=0&&this.decoder.needsNext(i)&&a.push(this.#a(o,r)),a.every(c=>c==="shown")?"ready":["broken","missing","working"].find(c=>a.includes(c))??"working"}decode(){let[e,t]=[this.#e,this.#r];this.#e=[],this.#t=t,this.#r=new Set;let r=this.decoder.decode(e,e.length>0?this.timing():void 0);return r.refused.forEach(({key:n})=>this.#s.add(n)),this.decoder.drop(t,this.keptWords),{changed:r.written.map(({wanted:n})=>n),pixels:r.pixels,behind:r.behind.length}}close(){this.#o=!0,this.decoder.destroy()}#a(e,t){let r=e+1;if(this.#r.add(r),this.decoder.has(r))return"shown";if(this.#s.has(r))return"broken";if(this.#n.has(r))return"working";let n=te(this.decoding,e,t);return n===void 0?"missing":(this.#n.add(r),this.decoding.pool.prepare(n,()=>!0).then(o=>{this.#n.delete(r),!this.#o&&(o!==void 0&&!this.decoder.add(r,o)&&(this.decoder.drop(this.#t,0),this.decoder.add(r,o)||(this.#s.add(r),this.decoding.onBroken("The graphics device has no room for the chunks of a frame."))),this.decoding.onReady())},o=>{this.#n.delete(r),this.#s.add(r),this.decoding.onBroken(o.message),this.decoding.onReady()}),"working")}},Vr=class{constructor(e,t){this.family=e;this.position=t}family;position;get stream(){return this.family.decoder.streams[this.position]}hasPicture(e){return this.family.decoder.showsAny(this.position,e)}shows(e){return this.family.shows(this.position,e)}ask(e,t){return this.family.ask(this.position,e,t)}prepare(e,t){return this.family.prepare(this.position,e,t)}};var It=class{#e;#t;#r;#n=[];constructor(e){if(this.#e=e,e.hasTimestamps){this.#t=e.device.createQuerySet({type:"timestamp",count:2*256});let t=GPUBufferUsage.QUERY_RESOLVE|GPUBufferUsage.COPY_SRC;this.#r=e.device.createBuffer({label:"timestamps",size:4096,usage:t})}}pass(e){if(this.#t===void 0||this.#n.length===256)return;let t=2*this.#n.length;return this.#n.push(e),{querySet:this.#t,beginningOfPassWriteIndex:t,endOfPassWriteIndex:t+1}}async read(){let e=new Map,[t,r,n]=[this.#t,this.#r,this.#n];if(this.#n=[],t===void 0||r===void 0||n.length===0)return e;this.#e.submit(a=>a.resolveQuerySet(t,0,2*n.length,r,0));let o=await this.#e.read(r,0,4*n.length),i=new BigUint64Array(o.buffer);return n.forEach((a,c)=>{let[u,l]=[i[2*c],i[2*c+1]],d=u>0n&&l>u?Number(l-u)/1e6:0;e.set(a,(e.get(a)??0)+d)}),e}};var Tl=256<<20;function Al({color:{header:s},alpha:e}){return s.kind==="color"&&!s.isHalf&&s.coding.name==="cells"&&e===void 0}var Bt=class s{constructor(e,t,r,n){this.gpu=e;this.scene=t;this.texels=r;this.presenter=n;this.#e=new Ot(e,r),this.#t=new It(e),this.#r=[new ke(e),new ke(e),new ke(e)],e.onError=o=>this.onFailed(`The graphics device failed: ${o}`),e.lost.then(o=>this.onFailed(`The graphics device was lost: ${o}`))}gpu;scene;texels;presenter;name="gpu";mostPixels=1/0;onFailed=()=>{};#e;#t;#r;#n;static async create(e,t){e.pipeline("render-pyramid").catch(()=>{});let[r,n]=await Promise.all([Ut.create(e,t.catalogue,t.mostImages),Ft.create(e,t.canvas)]).catch(o=>{throw new z(`The graphics device cannot draw the film: ${String(o)}`)});return new s(e,t,r,n)}get hasEffects(){return!this.gpu.isSoftware}async load(e,t){let{decoding:r,mostViews:n}=this.scene,o=new Map;for(let d of t.flatMap(f=>[f.depth,...Al(f)?[f.color]:[]])){let{kernel:f}=ye(d.header);o.set(f,[...o.get(f)??[],d])}let i=Math.floor(Tl/4/(2*n)),a=[...o.values()].map(d=>Pt.create(this.gpu,d,ve)),c=()=>this.#t.pass("decode"),u=(await Promise.all(a)).map(d=>new Lt(d,r,i,c)),l=new Map;for(let{decoder:d}of u)d.streams.forEach(({index:f},m)=>l.set(f,{decoder:d,position:m}));return this.texels.load(e,l),this.#n?.painter.forget(e),u}async draw(e,t){let{view:r,cameras:n,views:o}=e,i=performance.now(),{container:a,catalogue:c,canvas:u}=this.scene,l=Ue(e),d=r.overlays.has("holes"),f={...Xo,steps:r.steps,holes:d?"nearest":"behind",effects:this.hasEffects},[m,h,b]=this.#r,w=C=>{let J=oe=>a.probeAt(oe,r.frame);return{active:$o(c,o,C.eye,J),camera:C,size:l,settings:f}},_=()=>this.#t.pass("march");for(let[C,J]of n.entries())await this.#e.render(this.#r[C],{...w(J),timing:_});let v=yt(r);if(v.length>0){this.#n??=this.#s(),this.#n.painter.paint(v,e);let C=w(n[0]);await this.#e.render(b,{...C,active:{...C.active,coding:Po},colors:this.#n.view})}[u.width,u.height]=r.size;let x=v.length>0;this.presenter.show([m,n.length>1?h:m,x?b:m],{exposureEv:r.exposureEv,toneMap:r.toneMap,stereo:r.stereo,marksHoles:d,overlay:x?gt:0}),t();let P=await m.readCounters(),F=performance.now()-i,E=await this.#t.read();return{counters:P,decodeMs:E.get("decode")??0,marchMs:E.get("march")??F}}async decodeMs(){return(await this.#t.read()).get("decode")??0}async pixels(){let[e]=this.#r;return{size:[...e.size],rgba:await e.readPixels()}}close(){this.gpu.destroy()}#s(){let{container:e,catalogue:t}=this.scene,{arrays:r}=this.texels,n=r.overlayTexture();return{painter:new pe(e,t,({view:i,face:a},c,u)=>{r.upload(n,this.texels.tile(i,a),c,u)}),view:n.createView({dimension:"2d-array"})}}};var Pl={cacheBytes:256<<20,parallel:6,requestBytes:2<<20,retryDelayMs:200,maxDelayMs:1e4},Cl=4,ti=1e3;function Nl({offset:s,storedBytes:e}){return{key:ne({offset:s,storedBytes:e}),offset:s,bytes:e}}function ne({offset:s,storedBytes:e}){return`${s} ${e}`}var Dt=class{constructor(e,t=Pl){this.source=e;this.settings=t}source;settings;kept=new Map;wanted=new Map;wantedAt=new Map;inUse=new Set;pending=new Set;requests=new Set;everFetched=new Set;arrivals=[];timer;failures=0;closed=!1;counts={bytesFetched:0,requests:0,chunksFetched:0,chunksRefetched:0};cachedBytes=0;onChunk=()=>{};onProblem=()=>{};want(e,t=[]){let r=e.filter(({storedBytes:n})=>n>0).map(Nl);this.wanted=new Map(r.map(n=>[n.key,n])),this.wantedAt=new Map(r.map(n=>[n.offset,n])),this.inUse=new Set(t.map(ne));for(let n of[...this.inUse,...this.wanted.keys()])this.touch(n);this.trim(),this.pump()}get(e){return e.storedBytes===0?new Uint8Array(0):this.kept.get(ne(e))}get stats(){let e=performance.now();for(;this.arrivals.length>0&&this.arrivals[0].at<e-ti;)this.arrivals.shift();let t=this.arrivals.reduce((r,n)=>r+n.bytes,0);return{...this.counts,cacheBytes:this.cachedBytes,fetchRate:t*1e3/ti}}close(){this.closed=!0,clearTimeout(this.timer),this.requests.forEach(e=>e.abort.abort())}touch(e){let t=this.kept.get(e);t!==void 0&&(this.kept.delete(e),this.kept.set(e,t))}trim(){for(let[e,t]of this.kept){if(this.cachedBytes<=this.settings.cacheBytes)return;!this.wanted.has(e)&&!this.inUse.has(e)&&(this.kept.delete(e),this.cachedBytes-=t.length)}}isMissing(e){return e!==void 0&&!this.kept.has(e.key)&&!this.pending.has(e.key)}pump(){if(!(this.closed||this.timer!==void 0))for(let e of this.wanted.values()){if(this.requests.size>=this.settings.parallel)return;this.isMissing(e)&&this.fetch(this.runFrom(e))}}runFrom(e){let t=[e],r=e.offset+e.bytes;for(;;){let n=this.wantedAt.get(r);if(!this.isMissing(n)||r+n.bytes-e.offset>this.settings.requestBytes)return t;t.push(n),r+=n.bytes}}async fetch(e){let t={ranges:e,abort:new AbortController},r=e.reduce((o,{bytes:i})=>o+i,0);this.requests.add(t),e.forEach(({key:o})=>this.pending.add(o)),this.counts.requests+=1;let n;try{let o=await this.source.read(e[0].offset,r,t.abort.signal);this.closed||(this.failures=0,this.arrive(e,o))}catch(o){n=o}this.requests.delete(t),e.forEach(({key:o})=>this.pending.delete(o)),!this.closed&&(n!==void 0?this.fail(n):e.filter(({key:o})=>this.wanted.has(o)).forEach(({key:o})=>this.onChunk(o)),this.pump())}arrive(e,t){let r=0;for(let{key:n,bytes:o}of e)this.kept.set(n,t.slice(r,r+o)),this.cachedBytes+=o,this.counts.chunksFetched+=1,this.counts.chunksRefetched+=Number(this.everFetched.has(n)),this.everFetched.add(n),r+=o;this.counts.bytesFetched+=t.length,this.arrivals.push({at:performance.now(),bytes:t.length}),this.trim()}fail(e){if(e instanceof Re){this.closed=!0,this.requests.forEach(t=>t.abort.abort()),this.onProblem({fatal:!0,message:e.message});return}if(!(e instanceof A)){this.closed=!0,this.onProblem({fatal:!0,message:e instanceof Error?e.message:String(e)});return}if(this.failures+=1,this.failures>=Cl&&this.onProblem({fatal:!1,passes:!0,message:`${e.message}; trying again`}),this.timer===void 0){let t=this.settings.retryDelayMs*2**Math.min(this.failures-1,16);this.timer=setTimeout(()=>{this.timer=void 0,this.pump()},Math.min(t,this.settings.maxDelayMs))}}};function Ol({streams:s}){let e=s.reduce((r,{firstFrame:n})=>Math.min(r,n),1/0),t=s.reduce((r,{firstFrame:n,frameCount:o})=>Math.max(r,n+o-1),-1/0);return s.length===0?[0,0]:[e,t]}function Fl([s,e,t,r]){let n=[-2*(s*t+r*e),2*(r*s-e*t),2*(s*s+e*e)-1],o=Math.asin(Math.max(-1,Math.min(1,n[1])));return{yaw:Math.atan2(-n[0],-n[2]),pitch:o}}function Ul(s){let e=[0,1,2],t=o=>s.map(i=>i[o]),r=e.map(o=>t(o).reduce((i,a)=>Math.min(i,a),1/0)),n=e.map(o=>t(o).reduce((i,a)=>Math.max(i,a),-1/0));return{least:r,greatest:n}}function ri(s,e){return s.reduce((t,r,n)=>t+(r-e[n])**2,0)}function ni(s,e){let[t,r]=Ol(s),o=(f=>e.map(m=>s.probeAt(m,f)))(t),i=s.footage.poses,a=e.flatMap(f=>i.get(s.probes[f].name)??[]),c=Ul([...o,...a].map(({position:f})=>f)),u=c.least.map((f,m)=>(f+c.greatest[m])/2),l=o.reduce((f,m)=>ri(m.position,u)<ri(f.position,u)?m:f),d={eye:[...l.position],...Fl(l.orientation)};return{name:s.name,fileBytes:s.source.byteCount,framesPerSecond:s.fps,firstFrame:t,frameCount:r-t+1,headBox:c,probes:o.map(({name:f,position:m})=>({name:f,position:m})),nearM:Ll(s,e),start:d,streams:Il(s)}}function Ll({streams:s},e){return s.flatMap(({probe:r,header:n})=>n.kind==="depth"&&e.includes(r)?[n.range.nearM]:[]).reduce((r,n)=>Math.min(r,n),1/0)}function Il({streams:s,chunks:e}){let t=new Float64Array(s.length),r=new Set;for(let o of e){let i=ne(o);t[o.stream]+=r.has(i)?0:o.storedBytes,r.add(i)}let n=new Map;for(let{index:o,kind:i,codec:a}of s){let c=`${i} ${a}`,u=n.get(c)??{kind:i,codec:a,count:0,bytes:0};n.set(c,{...u,count:u.count+1,bytes:u.bytes+t[o]})}return[...n.values()]}var Ht=class{#e;#t;next(e,t,r){let n=this.#e,o=t&&n!==void 0&&!n.isWhole&&e>n.frame&&!this.#r(n,r);return(n===void 0||n.frame!==e&&!o)&&(this.#e={frame:e,sinceMs:r,isWhole:!1}),this.#e.frame}get shown(){return this.#t}show(e,t,r){let n=this.#e;return n.isWhole=e,(e||!t||this.#t===void 0||this.#r(n,r))&&(this.#t=n.frame),this.#t}#r({sinceMs:e},t){return t-e>=500}};function $r(s,e,t,r){let n=k().straightTexels(xo(s),e,t,r);return s.name==="light"?new Uint16Array(n.buffer):n}var Be=class{constructor(e,t){this.stream=e;this.decoding=t}stream;decoding;#e=new Set;#t=new Map;#r=new Set;#n=new Set;hasPicture(e){return this.#t.get(e)?.shown!==void 0}shows({unit:e,chunk:t,frame:r}){let n=this.#t.get(e)?.shown;return n?.chunk===t&&n.frame===r}frame(e){return this.#t.get(e)?.shown?.frame}pixels(e){return this.#t.get(e)?.shown?.pixels}takeChanged(){let e=[...this.#e];return this.#e=new Set,e}ask(e,t){let{ready:r}=this.#s(e.unit);[...r.keys()].filter(i=>!pt(this.decoding.frames,i)).forEach(i=>r.delete(i));let o=this.prepare(e,t);return o==="ready"&&(this.#o(e.unit,r.get(e.frame)),r.delete(e.frame)),o}prepare(e,t){return this.shows(e)?"shown":this.#s(e.unit).ready.get(e.frame)?.chunk===e.chunk?"ready":this.#i(e,t)}#s(e){let t=this.#t.get(e)??{shown:void 0,ready:new Map,working:new Set};return this.#t.set(e,t),t}#o(e,t){this.#s(e).shown=t,this.#e.add(e)}#i(e,t){if(this.#r.has(e.chunk))return"broken";let r=this.#s(e.unit),n=te(this.decoding,e.chunk,t),o=e.next>=0&&this.#n.has(e.chunk),i=o?te(this.decoding,e.next,t):void 0;if(n===void 0||o&&i===void 0)return"missing";if(!r.working.has(e.frame)){r.working.add(e.frame);let a=e.frame-n.chunk.firstFrame;this.decoding.pool.decode(n,a,()=>pt(this.decoding.frames,e.frame),i).then(u=>this.#a(e,u),u=>this.#l(e,u))}return"working"}#a(e,t){let r=this.#s(e.unit);if(r.working.delete(e.frame),t==="next")this.#n.add(e.chunk);else if(t!==void 0){let n={pixels:t,chunk:e.chunk,frame:e.frame},{frames:o}=this.decoding;e.frame===o.shown||r.shown===void 0?this.#o(e.unit,n):pt(o,e.frame)?r.ready.set(e.frame,n):(r.shown.frame>o.shown||r.shown.frame<e.frame&&e.frame<o.shown)&&this.#o(e.unit,n)}this.decoding.onReady()}#l(e,t){this.#s(e.unit).working.delete(e.frame),this.#r.add(e.chunk),this.decoding.onBroken(t.message),this.decoding.onReady()}};var Gt=class s{constructor(e,t,r,n){this.context=e;this.view=t;this.streams=r;this.#e=n.families,this.#t=n.sources;let{container:o}=e.decoding;this.#r=o.footage.poses.has(o.probes[r.probe].name)}context;view;streams;#e;#t;#r;#n=[];lastUsed=0;static async load(e,t,r){let{renderer:n,decoding:o}=e,i=new Map,a=await n.load(t,r.faces,(u,l)=>i.get(u)?.pixels(l)),c=new Map;for(let u of a)u.decoder.streams.forEach((l,d)=>c.set(l,u.units(d)));for(let u of r.faces.flatMap(me).filter(l=>!c.has(l))){let l=new Be(u,o);i.set(u.index,l),c.set(u,l)}return new s(e,t,r,{families:a,sources:c})}ask(e,{sees:t,fetch:r,counts:n}){this.#n=[],this.#s(e,t,(o,i,a,c)=>{c!==void 0&&(n[i.ask(c,r)]+=1),this.#r&&this.#n.push({stream:o,source:i,unit:a,wanted:c})})}prepare(e,{sees:t,fetch:r,counts:n}){this.#s(e,t,(o,i,a,c)=>{c!==void 0&&(n[i.prepare(c,r)]+=1)})}#s(e,t,r){let{container:n}=this.context.decoding;for(let[o,i]of this.#t)for(let a=0;a<n.unitCount(o.index);a+=1)r(o,i,a,t(o,a)?bt(n,o.index,a,e):void 0)}update(){let{texels:e}=this.context.renderer,[t,r,n]=[0,0,0];for(let o of this.#e){let i=o.decode();r+=i.pixels,n+=i.behind,t+=i.changed.length;for(let{stream:a,unit:c}of i.changed)e.written(o.decoder.streams[a].index,c)}for(let o of this.streams.faces){let i=this.#a(o);t+=i.length,r+=i.reduce((a,[c,u])=>{let[,,l,d]=this.context.decoding.container.unitRect(c.index,u);return a+l*d},0)}return this.#o(),{units:t,pixels:r,behind:n}}#o(){let{texels:e}=this.context.renderer;for(let{stream:t,source:r,unit:n,wanted:o}of this.#n){let i=o!==void 0&&r.shows(o);i&&!e.isKnown(t.index,n)?e.written(t.index,n):!i&&r.hasPicture(n)&&e.forget(t.index,n)}this.#n=[]}unload(){this.context.renderer.texels.unload(this.view),this.#e.forEach(e=>e.close())}#i(e){let t=e&&this.#t.get(e);return t instanceof Be?t:void 0}#a({depth:e,color:t,alpha:r,material:n}){let{texels:o}=this.context.renderer,[i,a,c]=[t,r,n].map(h=>this.#i(h)),l=(this.#i(e)?.takeChanged()??[]).map(h=>[e,h]);for(let h of c?.takeChanged()??[])o.uploadMaterial(c.stream.index,h,c.pixels(h)),l.push([c.stream,h]);let d=i?.takeChanged()??[],f=a?.takeChanged()??[],m=f.flatMap(h=>[...be(t,this.#m(a,h).rect)]);for(let h of new Set([...d,...m.map(([b])=>b)]))i!==void 0&&i.hasPicture(h)&&this.#l(i,h,a)&&l.push([t,h]);return l.push(...f.map(h=>[a.stream,h])),l.forEach(([h,b])=>o.written(h.index,b)),l}#l(e,t,r){let{renderer:n,coding:o}=this.context,{texels:i}=n,a=this.#m(e,t);if(r===void 0)return i.uploadColor(e.stream.index,a.rect,$r(o,a,a.rect)),!0;let c=!0;for(let[u,l]of be(r.stream,a.rect))r.frame(u)===e.frame(t)?i.uploadColor(e.stream.index,l,$r(o,a,l,this.#m(r,u))):c=!1;return c}#m(e,t){return{pixels:e.pixels(t),rect:this.context.decoding.container.unitRect(e.stream.index,t)}}};var zt=class{constructor(e,t,r){this.outline=r;this.members=Array.from({length:e},()=>this.member(t()))}outline;members;nextId=0;onFailed=()=>{};get pending(){return this.members.reduce((e,{queue:t,sent:r})=>e+t.length+r.size,0)}async prepare(e,t){let r=await this.run({...e,id:this.nextId++},t);return r&&"prepared"in r?r.prepared:void 0}async decode(e,t,r,n){let o={...e,id:this.nextId++,frame:t,...n&&{next:n}},i=await this.run(o,r);return i&&"needsNext"in i?"next":i&&"pixels"in i?i.pixels:void 0}async codings(e,t,r){let n=await this.run({...e,id:this.nextId++,frame:t,asksCodings:!0},r);return n&&"pixels"in n?n.pixels:void 0}close(){this.members.forEach(({worker:e})=>e.terminate()),this.members.forEach(e=>e.queue=[])}member(e){let t={worker:e,knows:new Set,queue:[],sent:new Map,failure:void 0};return e.onmessage=({data:r})=>this.finish(t,r),e.onerror=({message:r})=>this.fail(t,`A worker of the player failed: ${r??"it did not load"}`),e.onmessageerror=()=>this.fail(t,"A worker of the player failed: its answer cannot be read"),t}async run(e,t){let{stream:r,unit:n}=e.chunk,o=this.members[(r+n)%this.members.length],i=await new Promise(a=>{o.queue.push({job:e,isWanted:t,resolve:a}),this.pump(o)});if(i&&"error"in i)throw new Error(i.error);return i}pump(e){for(;e.sent.size<8&&e.queue.length>0;){let t=e.queue.shift(),{job:r}=t;if(e.failure!==void 0){t.resolve({id:r.id,error:e.failure});continue}if(!t.isWanted()){t.resolve(void 0);continue}e.sent.set(r.id,t);let{stream:n}=r.chunk,o=e.knows.has(n)?void 0:this.outline(n);e.knows.add(n),e.worker.postMessage({...r,...o&&{outline:o}})}}fail(e,t){e.failure===void 0&&(e.failure=t,this.onFailed(t)),[...e.sent.keys()].forEach(r=>this.finish(e,{id:r,error:t})),this.pump(e)}finish(e,t){let r=e.sent.get(t.id);e.sent.delete(t.id),r?.resolve(t),this.pump(e)}};var Bl=5,Dl=200;async function Wt(s){for(let e=1;;e+=1)try{return await s()}catch(t){if(!(t instanceof A)||e===Bl)throw t;await new Promise(r=>setTimeout(r,Dl*2**(e-1)))}}var si=1<<30,Hl=4,Gl=512<<20,zl=4,Wl=3,jl=3,Vl=2,$l=.5,Kl=6,ql=300,Xl=1e3,Yl=1500;async function oi(s,e,t){let[r,n]=await Promise.allSettled([Ql(t),Wt(()=>ut.open(s))]);if(r.status==="rejected")throw r.reason;let o=r.value,i,a;try{if(n.status==="rejected")throw n.reason;let c=n.value,u=Eo(c),l=Math.max(...u.views.map(({faces:m})=>m.length)),d=Jl(u,l,o===void 0);i=Zl(c);let f={container:c,catalogue:u,canvas:e,decoding:i,mostViews:d,mostImages:d*l};return a=o===void 0?new kt(f):await Bt.create(o,f),new Kr({renderer:a,decoding:i,catalogue:u,mostViews:d})}catch(c){throw i?.store.close(),i?.pool.close(),a?.close(),o?.destroy(),c}}function Jl(s,e,t){let{views:r}=s,n=e*Wl*wo(s);if(t&&n>si)throw new y("The images of a probe are larger than the processor draws; a graphics device may.");let o=Math.max(1,Math.floor(si/n));return Math.min(r.length,o,t?zl:1/0)}async function Ql(s){if(s==="cpu")return;let e=await Pr();return s==="auto"&&Cr(e)?void 0:lt.open(e)}function Zl(s){let e=Math.max(1,Math.min(Hl,(navigator.hardwareConcurrency||2)-1)),t={module:Te(),keptBytes:Gl/e},r=()=>{let i=He("worker.js",import.meta.url);return i.postMessage(t),i},n=new zt(e,r,i=>{let{kind:a,codec:c,face:u,width:l,height:d,unitWidth:f,unitHeight:m,headerBytes:h}=s.streams[i];return{stream:{kind:a,codec:c,face:u,width:l,height:d,unitWidth:f,unitHeight:m},headerBytes:h}}),o=new Dt(s.source);return{container:s,frames:{shown:0,next:[0,0]},store:o,pool:n,onReady:()=>{},onBroken:()=>{}}}var Kr=class{film;onProblem=()=>{};onShown=()=>{};#e;#t;#r;#n;#s;#o;#i;#a=new Map;#l;#m=new Map;#f;#p=0;#d=new Ht;#c;#u;#b=performance.now();#h=!1;#g=0;#x={cells_decoded:0,pixels_decoded:0};#k;#w=()=>{};#y=!1;constructor({renderer:e,decoding:t,catalogue:r,mostViews:n}){let{container:o,store:i,pool:a}=t;this.#e=e,this.#t=o,this.#r=r,this.#n=t,this.#l=n,this.film=ni(o,r.views.map(({probe:c})=>c)),this.#u=this.film.firstFrame,i.onChunk=c=>{this.#m.set(c,performance.now()),this.#w()},i.onProblem=c=>this.#_(c),this.#f=new wt(t),a.onFailed=c=>this.#_({fatal:!0,message:c}),e.onFailed=c=>this.#_({fatal:!0,isOfDevice:e.name==="gpu",message:c}),t.onReady=()=>this.#w(),t.onBroken=c=>this.#_({fatal:!1,message:c}),this.#s={renderer:e,decoding:t,coding:r.coding},this.#o=new Oe(o),this.#i=new Oe(o)}get renderer(){return this.#e.name}get mostPixels(){return this.#e.mostPixels}async draw(e){let t=await this.#R(e),{counts:r,active:n}=t,o=r.missing+r.working;this.#h||=o===0||performance.now()-this.#b>Yl;let i=this.#h?await this.#C(t):void 0;this.#u=o===0?t.view.frame:this.#u;let a=this.#n.store.stats;return{...a,counters:{...i?.counters,...this.#x,cells_unchanged:r.shown,bytes_read:a.bytesFetched,active_probes:n.length},decodeMs:i?.decodeMs??await this.#e.decodeMs(),marchMs:i?.marchMs??0,unitsMissing:o,unitsBroken:r.broken,overlayMissing:this.#p,shownFrame:this.#u}}async settle(e){for(;;){let t=new Promise(n=>this.#w=n),{counts:r}=await this.#R(e);if(r.missing+r.working===0||this.#y)return;await Promise.all([t,this.#e.decodeMs()])}}fetched(){let{firstFrame:e,frameCount:t}=this.film,r=this.#k;if(r===void 0)return[];let n=this.#P(r.pose.eye,r.frame),o=(l,d)=>this.#o.sees(l,d),i=this.#S(n,o,[0,1/0]).filter(l=>this.#n.store.get(l)===void 0).map(l=>[l.firstFrame,l.firstFrame+l.frameCount-1]).sort((l,d)=>l[0]-d[0]),a=[],c=e;for(let[l,d]of i)l>c&&a.push([c,l-1]),c=Math.max(c,d+1);let u=e+t-1;return c<=u?[...a,[c,u]]:a}pixels(){return this.#e.pixels()}close(){this.#y=!0,this.#w(),this.#n.store.close(),this.#n.pool.close(),this.#e.close()}#_(e){this.#y||this.onProblem(e)}async#R(e){let{playing:t}=e,r=this.#d.next(this.#F(e.frame),t,performance.now());this.#g+=1,this.#k=e,this.#A(e);let n=this.#M(e),o=this.#P(e.pose.eye,r);await this.#T(o),this.#o.look(n);let{renderer:i,decoding:a}=this.#s,{texels:c}=i,u=(E,C)=>this.#o.sees(E,C),l=()=>i.hasEffects&&o.some(E=>c.isSpecular(E,u)),d=l(),f=d?()=>!0:u,m=o.map(E=>this.#a.get(E)),h=[],b=(E,C,J)=>{let oe={shown:0,ready:0,working:0,missing:0,broken:0};return m.forEach(Di=>Di[E](C,{sees:f,fetch:J,counts:oe})),oe},w=[r,r+(t?jl:0)];a.frames={shown:this.#d.shown??r,next:w};let _=b("prepare",r,h),v=this.#d.show(_.missing+_.working===0,t,performance.now());a.frames={shown:v,next:w};let x=b("ask",v,h);for(let E=r+1;E<=w[1];E+=1)b("prepare",E,[]);let P={...e,frame:v};this.#p=this.#E(P,o,h);let F=[...new Set([r,v])].flatMap(E=>this.#S(o,f,[E,E]));a.store.want([...h,...this.#U({...e,frame:r},o,n)],F);for(let E of m){let{units:C,pixels:J,behind:oe}=E.update();x.working+=oe,this.#x.cells_decoded+=C,this.#x.pixels_decoded+=J}return c.update(),x.working+=Number(l()&&!d),x.working>0&&a.pool.pending===0&&this.#w(),{view:P,active:o,cameras:n,counts:v===r?x:_}}#E({overlays:e,frame:t},r,n){if(!e.has("nodes"))return this.#f.clear(),0;let o=[];for(let{depth:i}of r.flatMap(a=>this.#r.views[a].faces))for(let a=0;a<this.#t.unitCount(i.index);a+=1){let c=this.#o.sees(i,a)&&bt(this.#t,i.index,a,t);c&&o.push({...c,stream:i.index})}return this.#f.show(o,n)}#M(e){let[t,r]=e.size,n=e.stereo==="side-by-side",o=go(e.pose,e.fovDeg,(n?t/2:t)/r);return e.stereo==="mono"?[o]:yo(o,e.eyeDistance)}#A({pose:{eye:e}}){let t=performance.now(),r=this.#c;if(r===void 0)this.#c={eye:[...e],ms:t,velocity:[0,0,0]};else if(r.eye.join()!==e.join()){let n=Math.max((t-r.ms)/1e3,.01),o=N(Z(e,r.eye),1/n);this.#c={eye:[...e],ms:t,velocity:q(o)<=Kl?o:[0,0,0]}}else t-r.ms>ql&&(r.velocity=[0,0,0])}#F(e){let t=this.#r.views.flatMap(Nr);if(t.some(([n,o])=>n<=e&&e<=o))return e;let r=t.map(([,n])=>n).filter(n=>n<e);return r.length>0?Math.max(...r):Math.min(...t.map(([n])=>n))}#P(e,t){let r=this.#r.views.flatMap((n,o)=>{let{position:i}=this.#t.probeAt(n.probe,t);return ko(n,t)?[{view:o,position:i}]:[]});return So(r,e,this.#l)}async#T(e){for(let t of e.filter(r=>!this.#a.has(r))){for(;this.#a.size>=this.#l;){let r=[...this.#a].filter(([i])=>!e.includes(i)),[n,o]=r.reduce((i,a)=>a[1].lastUsed<i[1].lastUsed?a:i);o.unload(),this.#a.delete(n)}this.#a.set(t,await Gt.load(this.#s,t,this.#r.views[t]))}e.forEach(t=>this.#a.get(t).lastUsed=this.#g)}#U(e,t,r){let{frame:n}=e,o=[],i=this.#c?.velocity??[0,0,0];if(q(i)>0){let a=j(e.pose.eye,N(i,$l));this.#i.look(r.map(c=>({...c,eye:a}))),o.push(...this.#S(t,(c,u)=>this.#i.sees(c,u),[n,n]))}if(e.playing){let a=n+Math.ceil(Vl*this.film.framesPerSecond),c=this.#S(t,(u,l)=>this.#o.sees(u,l),[n+1,a]);o.push(...c.sort((u,l)=>u.firstFrame-l.firstFrame))}return o}#S(e,t,r){let n=[];for(let o of e.flatMap(i=>this.#r.views[i].faces).flatMap(me))for(let i=0;i<this.#t.unitCount(o.index);i+=1)if(t(o,i)){let[a,c]=this.#t.chunksAmong(o.index,i,r);n.push(...this.#t.chunks.slice(a,c))}return n}#C({view:e,active:t,cameras:r}){let n=performance.now(),o=a=>{let c=this.#m.get(ne(this.#t.chunks[a]));return c!==void 0&&n-c<Xl},i=(a,c)=>this.#f.of(a,c);return this.#e.draw({view:e,cameras:r,views:t,isFresh:o,codings:i},()=>this.onShown())}};var ii=2**28,ai=2**30,ed=12,ui=24,td=[137,80,78,71,13,10,26,10];function rd(s){return s<=.04045?s/12.92:((s+.055)/1.055)**2.4}function nd(s,e){let t=new DataView(s.buffer,s.byteOffset,s.byteLength);if(!(s.length>=ui&&td.every((o,i)=>s[i]===o))||t.getUint32(12)!==1229472850)throw new g(`${e} is no PNG picture.`);let n=[t.getUint32(16),t.getUint32(20)];if(n[0]===0||n[1]===0||n[0]*n[1]>ii)throw new y(`${e} has ${n[0]}x${n[1]} pixels; the player shows up to ${ii}.`);return n}function ci(s,e,t){let r=Math.floor(t[0]/e.columns),n=Math.floor(t[1]/e.rows),o=e.rows-1-Math.floor(s/e.columns);return[s%e.columns*r,o*n,r,n]}function sd(s,e){let t=Math.min(s[0],s[1]*e);return[Math.max(1,Math.round(t)),Math.max(1,Math.round(t/e))]}async function li(s,e,{name:t,layout:r}){if(s.byteCount>ai)throw new y(`The quilt has ${s.byteCount} bytes; the player reads up to ${ai}.`);let n=performance.now(),o=await s.read(0,s.byteCount),i=nd(o.subarray(0,ui),"The quilt");if(i[0]<r.columns||i[1]<r.rows)throw new g(`The quilt has fewer pixels than its ${r.columns}x${r.rows} tiles.`);let a=await createImageBitmap(new Blob([o],{type:"image/png"})).catch(()=>{throw new g("The quilt is a damaged PNG picture, or one that this browser does not read.")}),c=document.createElement("canvas");[,,c.width,c.height]=ci(0,r,i);let[u,l]=[e.getContext("2d"),c.getContext("2d")];if(u===null||l===null)throw new y("The browser has no memory for a picture.");let d=performance.now()-n,f=r.columns*r.rows,m={eye:[0,0,0],yaw:0,pitch:0},h=w=>({counters:{views:f,width:i[0],height:i[1]},decodeMs:d,marchMs:0,fetchRate:0,bytesFetched:o.length,requests:1,chunksFetched:1,chunksRefetched:0,cacheBytes:4*i[0]*i[1],unitsMissing:0,unitsBroken:0,overlayMissing:0,shownFrame:w}),b={film:{name:t,fileBytes:s.byteCount,framesPerSecond:ed,firstFrame:0,frameCount:f,startFrame:Math.floor(f/2),headBox:{least:[0,0,0],greatest:[0,0,0]},probes:[],start:{...m,eye:[0,0,0]},streams:[{kind:"quilt",codec:"PNG",count:f,bytes:o.length}]},draw(w){let[_,v]=sd(w.size,r.aspect);[e.width,e.height]=[_,v];let[x,P]=ci(w.frame,r,i);return l.clearRect(0,0,c.width,c.height),l.drawImage(a,-x,-P),u.imageSmoothingQuality="high",u.drawImage(c,0,0,_,v),b.onShown(),Promise.resolve(h(w.frame))},settle:()=>Promise.resolve(),fetched:()=>[[0,f-1]],pixels(){let{data:w}=u.getImageData(0,0,e.width,e.height),_=Float32Array.from(w,(v,x)=>x%4===3?v/255:rd(v/255));return Promise.resolve({size:[e.width,e.height],rgba:_})},onProblem:()=>{},onShown:()=>{},close:()=>a.close()};return b}var od=["probes","nodes","holes","units","keyframes","fetched"],id="glb.js";async function di({url:s}){let e=Se(new URL(s).pathname.split("/").pop()??"");return e===void 0?Wt(()=>ze.open(s)):new Qe(e)}async function ad(s,e){let t=await di(s),{openScene:r}=await import(Q(id,import.meta.url)),n=await r(t,e,s.name),o={player:n,marks:["overdraw"],isFixed:!1,showOverdraw:i=>n.showOverdraw(i)};return await n.hasHeadset()&&(o.enterHeadset=i=>n.enterHeadset(i)),o}async function fi(s,e,t){if(s.kind==="glb")return ad(s,e);let r=await di(s);if(s.kind==="lfold")return{player:await oi(r,e,t),marks:od,isFixed:!1};if(s.quilt===void 0)throw new S("film.json, quilt: columns and rows were expected.");return{player:await li(r,e,{name:s.name,layout:s.quilt}),marks:[],isFixed:!0}}function jt({least:s,greatest:e}){let t=s.map((r,n)=>e[n]-r);return Math.max(.1*Math.max(...t),.1)}function mi(s,e,[t,r],n){if(e<0)return-mi(-s,-e,[-r,-t],n);let o=Math.min(e,Math.max(r-s,0)),i=r+n,a=e-o;if(a===0)return s+o;let c=Math.max(s,r);return i-Math.max(i-c,0)*Math.exp(-a/n)}function hi(s,e,t){let r=jt(t),n=o=>mi(s[o],e[o],[t.least[o],t.greatest[o]],r);return[n(0),n(1),n(2)]}function se(s,e){let t=jt(e),r=n=>Math.min(Math.max(s[n],e.least[n]-t),e.greatest[n]+t);return[r(0),r(1),r(2)]}var pi=[.0002777777777777778,1e4];function cd(s){return Math.min(Math.max(s||0,pi[0]),pi[1])}var Vt=class{#e;#t=0;#r=0;#n=!1;#s=1;isLooped=!0;constructor(e){this.#e={...e,framesPerSecond:cd(e.framesPerSecond)}}get isPlaying(){return this.#n}get lastFrame(){return this.#e.firstFrame+this.#e.frameCount-1}frame(e){let{firstFrame:t,frameCount:r}=this.#e,n=this.#i(e);return n>=r&&(this.isLooped?n%=r:(n=r-1,this.#n=!1),this.#t=n,this.#r=e),t+Math.floor(n)}play(e){let t=!this.isLooped&&this.frame(e)===this.lastFrame;this.#o(t?0:this.#i(e),e),this.#n=this.#e.frameCount>1}pause(e){this.#o(this.frame(e)-this.#e.firstFrame,e),this.#n=!1}seek(e,t){let r=Math.round(e)-this.#e.firstFrame;this.#o(Math.min(Math.max(r,0),this.#e.frameCount-1),t)}step(e,t){this.pause(t);let{frameCount:r}=this.#e,n=this.#t+e,o=(n%r+r)%r;this.#t=this.isLooped?o:Math.min(Math.max(n,0),r-1)}setSpeed(e,t){this.#o(this.#i(t),t),this.#s=e}#o(e,t){this.#t=e,this.#r=t}#i(e){let t=this.#n?Math.max(e-this.#r,0):0;return this.#t+t/1e3*this.#s*this.#e.framesPerSecond}};var ud=2e3,ld=1e9,dd=/^-?(\d+(\.\d*)?|\.\d+)(e[+-]?\d{1,2})?$/i,wi=[["ev","exposureEv"],["fov","fovDeg"],["eyes","eyeDistance"],["steps","steps"],["scale","scale"],["speed","speed"]];function Xr(s){return s!==null&&s.length<=40&&dd.test(s)?Number(s):void 0}function bi(s,e,t){let n=(s?.split(",",e+1)??[]).map(Xr),o=i=>i!==void 0&&Math.abs(i)<=t;return n.length===e&&n.every(o)?n:void 0}function qr(s,e){return s.find(t=>t===e)}function fd(s){if(s===null)return;let e=new Set(s.split(","));return new Set(br.filter(t=>e.has(t)))}function md(s){return Object.fromEntries(Object.entries(s).filter(([,e])=>e!==void 0))}function $t({eye:s,look:e}){return s!==void 0||e!==void 0}function Kt(s){if(s.length>ud)return{settings:{}};let e=new URLSearchParams(s.replace(/^#/,"")),t=bi(e.get("eye"),3,ld),r=bi(e.get("look"),2,1e6),n=Xr(e.get("frame")),o=md({toneMap:qr(Ve,e.get("tone")),stereo:qr($e,e.get("stereo")),isLooped:e.get("loop")===null?void 0:e.get("loop")!=="0",marks:fd(e.get("show")),renderer:qr(Ke,e.get("renderer"))});for(let[a,c]of wi){let u=Xr(e.get(a));u!==void 0&&(o[c]=V(c,u))}let i={settings:o};if(t!==void 0&&(i.eye=t),r!==void 0){let[a,c]=r.map(u=>u*Math.PI/180);i.look=[pr(a),Math.min(Math.max(c,-ee),ee)]}return n!==void 0&&Number.isSafeInteger(n)&&n>=0&&(i.frame=n),i}function D(s,e){return String(Number(s.toFixed(e))+0)}function gi(s,e,t){let r=[s.yaw,s.pitch].map(i=>D(i*180/Math.PI,3)),n=[`eye=${s.eye.map(i=>D(i,5)).join(",")}`,`look=${r.join(",")}`];n.push(`frame=${e}`);let o=(i,a,c)=>{a!==c&&n.push(`${i}=${a}`)};for(let[i,a]of wi)o(i,D(t[a],4),D(U[a],4));return o("tone",t.toneMap,U.toneMap),o("stereo",t.stereo,U.stereo),o("loop",t.isLooped?"1":"0",U.isLooped?"1":"0"),o("renderer",t.renderer,U.renderer),o("show",br.filter(i=>t.marks.has(i)).join(","),""),`#${n.join("&")}`}var yi=/[\u0000-\u001f\u007f-\u009f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]/;function hd(s){return[...new TextEncoder().encode(s)].map(t=>`\\${t.toString(8).padStart(3,"0")}`).join("")}function pd(s){let e=s.startsWith("-")?`./${s}`:s;return yi.test(e)?`$'${e.replace(/[\\']/g,"\\$&").replace(new RegExp(yi,"g"),hd)}'`:`'${e.replaceAll("'","'\\''")}'`}function _i(s,e){let t=["lightfold","render",pd(s)],{pose:r,stereo:n}=e,o=mr(r),i=c=>c.map(u=>D(u,5)).join(",");t.push("--eye",i(r.eye)),t.push("--look-at",i(r.eye.map((c,u)=>c+o[u]))),t.push("--fov",D(e.fovDeg,3));let a=n==="side-by-side"?2:1;return t.push("--size",`${Math.max(1,Math.round(e.size[0]/a))}x${e.size[1]}`),a===2&&t.push("--stereo","side-by-side","--eye-distance",D(e.eyeDistance,4)),e.frame!==void 0&&t.push("--frames",String(e.frame)),t.push("-o","view.png"),t.join(" ")}var bd=new Map([[" ","play"],["k","play"],[",","step-back"],[".","step-forward"],["Home","first"],["End","last"],["l","loop"],["[","slower"],["]","faster"],["0","reset"],["r","reset"],["m","lock-pointer"],["v","settings"],["i","inspector"],["h","help"],["?","help"],["f","full-screen"],["c","screenshot"]]),Jr=new Set(["Home","End","ArrowLeft","ArrowRight","ArrowUp","ArrowDown"]),vi=new Set([...Jr," ","Enter"]),wd={picture:new Set,panel:Jr,slider:Jr,widget:vi,text:vi};function Qr(s,e){return!(s.ctrlKey||s.altKey||s.metaKey)&&e!=="text"&&!wd[e].has(s.key)}function xi(s,e){let t=s.key.length===1?s.key.toLowerCase():s.key;return Qr(s,e)?bd.get(t):void 0}var ki=new Map([["KeyW",[0,0,1]],["KeyS",[0,0,-1]],["KeyA",[-1,0,0]],["KeyD",[1,0,0]],["KeyE",[0,1,0]],["KeyQ",[0,-1,0]]]),Ei=new Map([["ArrowLeft",[1,0]],["ArrowRight",[-1,0]],["ArrowUp",[0,1]],["ArrowDown",[0,-1]]]);function Si(s){return ki.has(s)||Ei.has(s)}function Zr(s){let e={step:[0,0,0],turn:[0,0]};for(let t of s)ki.get(t)?.forEach((r,n)=>e.step[n]+=r),Ei.get(t)?.forEach((r,n)=>e.turn[n]+=r);return e}var Yr=.15;function qt(s){let e=Math.abs(s??0);return e<Yr?0:Math.sign(s??0)*Math.min((e-Yr)/(1-Yr),1)}function Ri({axes:s,buttons:e}){let t=(e[7]?.value??0)-(e[6]?.value??0);return{step:[qt(s[0]),t,-qt(s[1])],turn:[-qt(s[2]),-qt(s[3])]}}var Mi=[[0,"play"],[3,"reset"],[4,"step-back"],[5,"step-forward"]];function Ti(s){let e=[...s],t=e.reduce((o,i)=>o+i.x,0)/e.length,r=e.reduce((o,i)=>o+i.y,0)/e.length,n=e.reduce((o,i)=>o+Math.hypot(i.x-t,i.y-r),0)/e.length;return{x:t,y:r,spread:n}}var Xt=class{#e;#t;#r=new Map;constructor(e,t){this.#e=e,this.#t=t,e.addEventListener("pointerdown",n=>this.#n(n)),e.addEventListener("pointermove",n=>this.#o(n));let r=n=>this.#s(n);e.addEventListener("pointerup",r),e.addEventListener("pointercancel",r),e.addEventListener("dblclick",()=>this.toggleLock()),e.addEventListener("wheel",n=>this.#i(n),{passive:!1})}toggleLock(){if(document.pointerLockElement===this.#e){document.exitPointerLock();return}this.#e.requestPointerLock()?.catch(()=>{})}#n(e){e.button!==0||document.pointerLockElement===this.#e||(this.#e.setPointerCapture(e.pointerId),this.#r.set(e.pointerId,{x:e.clientX,y:e.clientY}),this.#e.classList.add("dragged"))}#s(e){this.#r.delete(e.pointerId),this.#e.classList.toggle("dragged",this.#r.size>0)}#o(e){if(document.pointerLockElement===this.#e){let c=.0022*this.#t.fovDeg()/60;this.#t.turn(-e.movementX*c,-e.movementY*c);return}let t=this.#e.getBoundingClientRect();if(this.#t.hover(Math.min(Math.max((e.clientX-t.left)/Math.max(t.width,1),0),1)),!this.#r.has(e.pointerId))return;let r=Ti(this.#r.values());this.#r.set(e.pointerId,{x:e.clientX,y:e.clientY});let n=Ti(this.#r.values()),[o,i]=[n.x-r.x,n.y-r.y],a=Math.max(t.height,1);if(this.#r.size===1){let c=this.#t.fovDeg()*Math.PI/180/a;this.#t.turn(o*c,i*c)}else{let c=this.#t.reach()/a;this.#t.move([-o*c,i*c,2*(n.spread-r.spread)*c])}}#i(e){if(e.ctrlKey)return;e.preventDefault();let t=e.deltaMode===WheelEvent.DOM_DELTA_PIXEL?e.deltaY:e.deltaY*32;this.#t.zoom(Math.exp(Math.min(Math.max(t,-300),300)*.001))}};var gd=70,yd=4,Ai=.5;function _d(s){return CSS.supports("selector(:open)")&&s.matches(":open")}function vd(s){if(!(s instanceof HTMLElement))return"picture";if(s instanceof HTMLSelectElement)return _d(s)?"text":"widget";if(s instanceof HTMLInputElement){let e=["checkbox","radio","button"].includes(s.type);return s.type==="range"?"slider":e?"widget":"text"}return s.matches("aside, aside section")?"panel":s.closest("button, a, summary, pre, aside")===null?"picture":"widget"}var Yt=class{#e;#t;#r=new Map;#n=0;#s=new Set;#o=!1;constructor(e,t){this.#e=t,this.#t=new Xt(e,t),window.addEventListener("keydown",o=>this.#i(o)),window.addEventListener("keyup",o=>this.#a(o)),window.addEventListener("blur",()=>{this.#r.clear(),this.#o=!1});let r=!1;window.addEventListener("pointerdown",()=>r=!0,{capture:!0}),window.addEventListener("keydown",()=>r=!1,{capture:!0});let n=({target:o},i)=>{r&&o instanceof Element&&o.closest(i)!==null&&e.focus({preventScroll:!0})};window.addEventListener("click",o=>n(o,"#tools button:not([aria-expanded='true']), #transport button")),window.addEventListener("change",o=>n(o,"select"))}advance(e){let t=Math.min(Math.max(e,0),Ai);this.#n=performance.now(),this.#l(Zr(this.#r.keys()),this.#o,t);for(let r of navigator.getGamepads?.()??[])r?.mapping==="standard"&&(this.#l(Ri(r),r.buttons[10]?.pressed===!0,t),this.#m(r))}toggleLock(){this.#t.toggleLock()}#i(e){this.#o=e.shiftKey;let t=vd(e.target),r=xi(e,t);r!==void 0?(e.preventDefault(),(!e.repeat||r.startsWith("step"))&&this.#e.act(r)):Si(e.code)&&Qr(e,t)&&(e.preventDefault(),this.#r.set(e.code,this.#r.get(e.code)??performance.now()))}#a(e){let t=this.#r.get(e.code);if(t!==void 0){let r=(performance.now()-Math.max(t,this.#n))/1e3;this.#l(Zr([e.code]),this.#o,Math.min(Math.max(r,0),Ai)),this.#r.delete(e.code)}this.#o=e.shiftKey}#l({step:e,turn:t},r,n){if(e.some(o=>o!==0)){let o=Math.max(1,Math.hypot(...e)),i=(r?yd:1)*this.#e.moveSpeed()*n/o;this.#e.move(e.map(a=>a*i))}if(t.some(o=>o!==0)){let o=gd*Math.PI/180*n*this.#e.fovDeg()/60;this.#e.turn(t[0]*o,t[1]*o)}}#m(e){for(let[t,r]of Mi){let n=`${e.index} ${t}`,o=e.buttons[t]?.pressed===!0;o&&!this.#s.has(n)?(this.#s.add(n),this.#e.act(r)):o||this.#s.delete(n)}}};var xd="http://www.w3.org/2000/svg",kd=2e3,Ed=.011,Sd=.02,Rd=.3;function Ee(s,e,t){let r=document.createElementNS(xd,e);return Object.entries(t).forEach(([n,o])=>r.setAttribute(n,String(o))),s.appendChild(r)}var Jt=class{#e;#t=1;#r={least:[0,0,0],greatest:[0,0,0]};#n;#s;constructor(e){this.#e=e}setFilm({headBox:e,probes:t}){this.#r=e;let r=jt(e),[n,,o]=e.least,[i,a]=[e.greatest[0]-n,e.greatest[2]-o],c=1.15*(Math.max(i,a)+2*r),u=[n+i/2,o+a/2];this.#t=c,this.#e.replaceChildren();let l=100/c;this.#e.setAttribute("viewBox",[-80,-50,160,100].join(" "));let d=Ee(this.#e,"g",{transform:`scale(${l}) translate(${-u[0]} ${-u[1]})`}),f=m=>({x:n-m,y:o-m,width:i+2*m,height:a+2*m});Ee(d,"rect",{...f(r),class:"margin"}),Ee(d,"rect",{...f(0),class:"box"});for(let{position:m}of t.slice(0,kd))Ee(d,"circle",{cx:m[0],cy:m[2],r:c*Ed,class:"probe"});this.#n=Ee(d,"path",{class:"cone"}),this.#s=Ee(d,"circle",{r:c*Sd,class:"eye"})}showPose({eye:e,yaw:t},r){let[n,,o]=se(e,this.#r),i=Math.min(r,170)*Math.PI/360,a=c=>{let u=this.#t*Rd;return`${n-Math.sin(c)*u} ${o-Math.cos(c)*u}`};this.#n?.setAttribute("d",`M${n} ${o}L${a(t+i)}L${a(t-i)}Z`),this.#s?.setAttribute("cx",String(n)),this.#s?.setAttribute("cy",String(o))}};function Md({stats:s,pictureMs:e,size:t},r){let n=[["Picture",Xe(e)],["Decoding",Xe(s.decodeMs)]];return r!=="quilt"&&n.push(["Rendering",Xe(s.marchMs)]),n.push(["Size",`${t[0]}×${t[1]}`]),r==="lfold"&&n.push(["Frame shown",String(s.shownFrame)],["Tiles and cells not loaded",G(s.unitsMissing)],["Tiles and cells damaged",G(s.unitsBroken)],["Rate",`${(s.fetchRate/1e6).toFixed(2)} MB/s`],["Requests",G(s.requests)],["Chunks",G(s.chunksFetched)],["Chunks fetched again",G(s.chunksRefetched)]),n.push(["Fetched",ie(s.bytesFetched)],["Cache",ie(s.cacheBytes)]),n}function en(s){let e=p(s,HTMLTableElement);return e.tBodies[0]??e.createTBody()}function Td(){let s=Or.map(({color:e,name:t})=>{let r=document.createElement("li"),n=r.appendChild(document.createElement("span"));return n.style.backgroundColor=`rgb(${e.join()})`,r.append(t),r});p("nodes-legend",HTMLUListElement).prepend(...s)}var Qt=class{#e=new Jt(p("map",SVGSVGElement));#t=[...p("marks",HTMLFieldSetElement).querySelectorAll("input")];#r=p("command",HTMLElement);#n;constructor(e,t){this.#n=e;for(let n of this.#t)n.addEventListener("change",()=>t(n.value,n.checked));Td();let r=H("copy-command",()=>{Ye(this.#r.textContent??"",r,this.#r)})}setFilm(e,t){this.#e.setFilm(e),p("marks",HTMLElement).hidden=t.length===0;for(let n of this.#t){let o=n.closest("label");o!==null&&(o.hidden=!t.some(i=>i===n.value))}let r=e.streams.map(({kind:n,codec:o,count:i,bytes:a})=>[n,o,G(i),ie(a)]);qe(en("streams"),r)}showMarks(e){for(let t of this.#t)t.checked=[...e].some(r=>r===t.value)}show(e){let{pose:t,stats:r}=e;qe(en("figures"),Md(e,this.#n));let n=Object.entries(r.counters).map(([a,c])=>[a,G(c)]);qe(en("counters"),n),this.#e.showPose(t,e.fovDeg);let o=[t.yaw,t.pitch].map(a=>`${(a*180/Math.PI).toFixed(1)}°`),i=t.eye.map(a=>(Number(a.toFixed(3))+0).toFixed(3)).join("  ");M(p("eye",HTMLElement),`Eye ${i} m
Yaw ${o[0]}  Pitch ${o[1]}`),M(this.#r,e.command??""),p("command-part",HTMLElement).hidden=e.command===void 0}};function Pi(s){document.querySelectorAll("[data-kinds]").forEach(e=>{e.hidden=!(e.dataset.kinds??"").split(" ").includes(s)})}function Ci(s,e){return s==="glb"?e?"The button Headset shows this scene in WebXR.":"This scene plays in WebXR, by a button that appears where the browser finds a headset.":s==="quilt"?"Quilts are for displays of Looking Glass; headsets show other forms of light fields.":"This page does not show light fields in headsets: WebXR takes pictures of WebGL in most browsers, and these are made by WebGPU. lightfold render --projection vr180 --stereo side-by-side makes pictures for headsets; lightfold simplify makes a scene (.glb) of a frame, which this page shows in WebXR."}var tn=class{#e=.25;factor(e){return e?this.#e:1}note(e,t){e>this.#e?this.#e=t<=100?e:this.#e:e===this.#e&&t>100?this.#e=Math.max(e/2,.125):e===this.#e&&t<20&&(this.#e=Math.min(e*2,1))}},Zt=class{#e;#t=new tn;#r=!0;#n=!0;#s=!1;#o=!1;#i=!1;#a=0;#l=-1/0;#m=-1/0;constructor(e){this.#e=e}change(){this.#r=!0}move(){this.#r=!0,this.#m=this.#e.now()}get isStill(){return this.#e.now()-this.#m>=180}get isFluent(){return this.#t.factor(!0)===1}get isSettled(){return!this.#o&&!this.#r&&!this.#n&&this.#a===1}tick(){let e=this.#e.now(),t=this.#t.factor(!this.isStill||this.#n),r=(this.#n||this.#s)&&e-this.#l>=100;this.#o||this.#i||!(this.#r||r||t>this.#a)||this.#f(t,e)}async#f(e,t){this.#o=!0,this.#r=!1;try{let r=await this.#e.draw(e);this.#l=this.#e.now(),this.#a=e,this.#n=r.unitsMissing>0,this.#s=r.overlayMissing>0,(r.unitsMissing===0||r.marchMs>0)&&this.#t.note(e,this.#l-t),this.#e.onDrawn(r,this.#l-t)}catch(r){this.#i=!0,this.#e.onFailed(r)}finally{this.#o=!1}}};var Ad=.05,Pd=.25,Cd=.5,Nd=12,Od=4,Fd=.1;function er({headBox:{least:s,greatest:e},nearM:t=1/0}){let r=Math.max(...s.map((n,o)=>e[o]-n));return Math.min(Ad*t,Pd*r)}function Ud(s,e,t){let r=2*Math.PI*t/Nd,n=Math.min(t/Od,1),o=e*n*n*(3-2*n),i=N(hr(s),o*Math.sin(r));return j(j(s.eye,i),[0,Cd*o*Math.cos(r),0])}var tr=class{#e="waits";#t;#r=0;constructor(){let e=({target:t})=>{t instanceof Element&&t.closest("#orbit-field")!==null||this.stop()};["pointerdown","wheel","keydown"].forEach(t=>window.addEventListener(t,e,{capture:!0,passive:!0}))}get isOn(){return this.#e!=="ended"}stop(){this.#e="ended"}ask(){this.#e="asked"}advance(e,{film:t,seconds:r,isShown:n,isFluent:o}){if((this.#e==="asked"||this.#e==="waits"&&o)&&n&&er(t)>0&&([this.#e,this.#t,this.#r]=["runs",e,0]),!(this.#e!=="runs"||this.#t===void 0))return this.#r+=Math.min(Math.max(r,0),Fd),Ud(this.#t,er(t),this.#r)}};var rr=class{#e=document.createElement("img");constructor(e,t){this.#e.className=t==="quilt"?"poster fits":"poster",this.#e.alt="",this.#e.addEventListener("error",()=>this.remove()),this.#e.src=Q(e.split("/").pop()??"",e),p("notice",HTMLElement).after(this.#e)}remove(){this.#e.remove()}};var Ld=/[^\p{L}\p{N}._-]+/gu;function Ni(s,e){return`${s.replace(/\.[a-z0-9]{1,8}$/i,"").replace(Ld,"_").replace(/^[._-]+|[._-]+$/g,"").slice(0,100)||"film"}_${String(e).padStart(4,"0")}.png`}async function Oi(s,e){let t=document.createElement("canvas");[t.width,t.height]=[s.width,s.height],t.getContext("2d")?.drawImage(s,0,0);let r=await new Promise(o=>t.toBlob(o,"image/png"));if(r===null)throw new Error("The picture cannot be saved: the browser gives no memory for it.");let n=document.createElement("a");n.href=URL.createObjectURL(r),n.download=e,n.click(),setTimeout(()=>URL.revokeObjectURL(n.href),1e4)}var Fi=[["exposureEv","exposure",s=>`${s>0?"+":""}${D(s,2)}`],["fovDeg","fov",s=>`${D(s,1)}°`],["eyeDistance","eye-distance",s=>`${D(s*1e3,0)} mm`]],Ui=[["scale","scale"],["steps","steps"],["speed","speed"]];function Id(s,e){[...s.options].some(t=>t.value===e)||s.add(new Option(e,e)),s.value=e}function rn(s,e,t){let r=p(s,HTMLSelectElement);r.addEventListener("change",()=>{let n=e.find(o=>o===r.value);n!==void 0&&t(n)})}var nr=class{constructor(e){for(let[t,r]of Fi){let n=p(r,HTMLInputElement);n.addEventListener("input",()=>e({[t]:V(t,Number(n.value))}))}for(let[t,r]of Ui){let n=p(r,HTMLSelectElement);n.addEventListener("change",()=>e({[t]:V(t,Number(n.value))}))}rn("tone-map",Ve,t=>e({toneMap:t})),rn("stereo",$e,t=>e({stereo:t})),rn("renderer",Ke,t=>e({renderer:t})),H("reset-settings",()=>{let{exposureEv:t,toneMap:r,fovDeg:n,stereo:o,eyeDistance:i,steps:a,scale:c}=U;e({exposureEv:t,toneMap:r,fovDeg:n,stereo:o,eyeDistance:i,steps:a,scale:c})})}show(e){for(let[t,r,n]of Fi)p(r,HTMLInputElement).value=String(e[t]),p(r,HTMLInputElement).setAttribute("aria-valuetext",n(e[t])),M(p(`${r}-value`,HTMLOutputElement),n(e[t]));for(let[t,r]of Ui)Id(p(r,HTMLSelectElement),String(e[t]));p("tone-map",HTMLSelectElement).value=e.toneMap,p("stereo",HTMLSelectElement).value=e.stereo,p("renderer",HTMLSelectElement).value=e.renderer,p("eye-distance",HTMLInputElement).disabled=e.stereo==="mono",p("loop",HTMLButtonElement).setAttribute("aria-pressed",String(e.isLooped))}};var Bd=["settings","inspector","help"],sr=class{#e=p("side",HTMLElement);#t=p("stage",HTMLElement);#r;#n;#s;constructor(e){this.#r=e,this.#e.addEventListener("keydown",t=>{t.key==="Escape"&&this.#n!==void 0&&this.toggle(this.#n)})}get open(){return this.#n}restore(){this.#e.hidden=this.#n===void 0}toggle(e){if(p(`open-${e}`,HTMLButtonElement).hidden)return;let t=document.activeElement,r=this.#e.contains(t);r||(this.#s=t instanceof HTMLElement&&t!==document.body?t:this.#t),this.#n=this.#n===e?void 0:e,this.restore();for(let n of Bd)p(n,HTMLElement).hidden=n!==this.#n,p(`open-${n}`,HTMLButtonElement).setAttribute("aria-expanded",String(n===this.#n));this.#n!==void 0?(this.#e.setAttribute("aria-labelledby",`${e}-title`),p(e,HTMLElement).focus({preventScroll:!0}),this.#e.scrollTop=0):r&&this.#s?.focus(),this.#r()}};function Li(s,e,t){return t>1?(s-e)/(t-1):0}function Dd(s,[e,t],r){let n=r-14,o=[];for(let[i,a]of s){let c=Math.max(i,e),u=Math.min(a,e+t-1);if(c<=u){let l=7+n*Math.max(Li(c-.5,e,t),0),d=7+n*Math.min(Li(u+.5,e,t),1);o.push(t>1?[l,d-l]:[7,n])}}return o}function Hd(s,e){let t=Math.max(1,Math.round(e)),r=Math.floor(s/t),n=i=>String(i).padStart(2,"0"),o=Math.floor(r/60);return[Math.floor(o/60),o%60,r%60,s%t].map(n).join(":")}var or=class{#e;#t=0;#r=1;#n=24;#s="Frame";#o="";constructor(e,t){this.#e=e,e.slider.addEventListener("input",()=>t(Number(e.slider.value)))}setFilm({firstFrame:e,frameCount:t,framesPerSecond:r},n){[this.#t,this.#r,this.#n]=[e,t,r],this.#s=n;let{slider:o,time:i}=this.#e;o.min=String(e),o.max=String(e+t-1),o.disabled=t<2,o.ariaLabel=n,i.hidden=n==="View",this.#o=""}showFrame(e,t){let{slider:r,label:n,time:o}=this.#e,i=t===e?"":` (shown: ${t})`,a=`${this.#s} ${e} of ${this.#t}–${this.#t+this.#r-1}`;n.textContent!==a&&(r.value=String(e),n.textContent=a,o.textContent=` · ${Hd(e-this.#t,this.#n)}`),r.setAttribute("aria-valuetext",`${this.#s} ${e}${i}`)}showFetched(e){let{canvas:t}=this.#e,[r,n]=[t.clientWidth,t.clientHeight],o=window.devicePixelRatio,i=JSON.stringify([e,r,n,o]),a=t.getContext("2d");if(!(i===this.#o||a===null)){this.#o=i,t.width=Math.round(r*o),t.height=Math.round(n*o),a.scale(o,o),a.fillStyle=getComputedStyle(t).color;for(let[c,u]of Dd(e,[this.#t,this.#r],r))a.fillRect(c,0,u,n)}}};var Gd=400,zd=200,Wd=8192,jd=.4,Ii=[.15,3],Vd=1e4,Bi=15e3,$d=400,De=[.25,.5,1,1.5,2],ar=class{#e;#t;#r=p("stage",HTMLElement);#n=new Je;#s=new ce(()=>{this.load()});#o=new sr(()=>this.#E=-1/0);#i=new nr(e=>this.#v(e));#a;#l;#m;#f=new tr;#p;#d={...U};#c;#u;#b;#h;#g=!1;#x;#k=!0;#w;#y=!1;#_=0;#R=-1/0;#E=-1/0;#M=-1/0;constructor(e,t){this.#e=e,this.#t=t,this.#a=new Qt(e.kind,(i,a)=>this.#J(i,a)),document.title=`⁨${e.name}⁩ · lightfold`;let r=p("film-name",HTMLElement);r.title=e.name,M(r,e.name);let n={slider:p("timeline",HTMLInputElement),canvas:p("fetched",HTMLCanvasElement),label:p("frame-label",HTMLElement),time:p("time-code",HTMLElement)};this.#l=new or(n,i=>this.#N(i)),this.#m=new Yt(this.#r,{act:i=>this.#B(i),turn:(i,a)=>this.#q(i,a),move:i=>this.#X(i),zoom:i=>this.#v({fovDeg:V("fovDeg",this.#d.fovDeg*i)}),hover:i=>this.#Y(i),fovDeg:()=>this.#d.fovDeg,moveSpeed:()=>this.#D(),reach:()=>this.#D()*2}),this.#ee();let o=Kt(location.hash);this.#d=this.#H(o),!$t(o)&&o.frame===void 0&&e.poster!==void 0&&(this.#p=new rr(e.poster,e.kind)),($t(o)||matchMedia("(prefers-reduced-motion: reduce)").matches)&&this.#f.stop(),this.#i.show(this.#d),this.#a.showMarks(this.#d.marks),window.addEventListener("hashchange",()=>this.#Q()),new ResizeObserver(()=>this.#c?.loop.change()).observe(this.#r),requestAnimationFrame(i=>this.#C(i))}async load(e){if(this.#g)return;this.#g=!0;let{renderer:t}=this.#d;this.#x=t,this.#w=e,this.#T(),this.#s.opening(this.#e.name);try{await this.#A(e===void 0?t:"cpu"),this.#s.hide(),this.#o.restore()}catch(r){this.#T(),this.#p?.remove(),this.#r.replaceChildren(),M(p("film-facts",HTMLElement),""),this.#s.failed(r),this.#u!==void 0&&this.#I(this.#b??0)}finally{this.#g=!1}this.#e.kind==="lfold"&&t!==this.#d.renderer&&await this.load()}async#A(e){let t=document.createElement("canvas");this.#r.replaceChildren(t);try{this.#F(await this.#t(this.#e,t,e),t)}catch(r){if(!(r instanceof z))throw r;this.#w=r.message,await this.#A("cpu")}}#F(e,t){let{player:r}=e,{film:n}=r,o=new Vt(n),i=d=>{this.#c?.player===r&&this.#S(d)},a=performance.now(),c=!1,u=new Zt({draw:d=>(c=d===1,r.draw(this.#$(d))),onDrawn:(d,f)=>{this.#c?.player===r&&(this.#h={stats:d,pictureMs:f,size:[t.width,t.height]},this.#U(),this.#k||=performance.now()-a>Vd)},onFailed:d=>i({fatal:!0,isOfDevice:r.renderer==="gpu",message:ae(d)}),now:()=>performance.now()});this.#c={...e,canvas:t,loop:u,clock:o},r.onProblem=i,r.onShown=()=>{this.#y&&(c||o.isPlaying)&&(this.#y=!1,this.#j(t))};let l=Kt(location.hash);this.#u??=this.#G(this.#O(n),l),this.#u={...this.#u,eye:se(this.#u.eye,n.headBox)},o.isLooped=this.#d.isLooped,o.setSpeed(this.#d.speed,performance.now()),o.seek(this.#b??l.frame??nn(n),performance.now()),this.#P(e),e.showOverdraw?.(this.#d.marks.has("overdraw"))}#P({player:{film:e,renderer:t},marks:r,isFixed:n,enterHeadset:o}){let i=e.frameCount<2,a=this.#e.kind==="quilt";Pi(this.#e.kind),this.#r.classList.toggle("fits",n),a&&(this.#r.ariaDescription="The pointer chooses the view, Space plays, H opens help."),["transport","help-playing"].forEach(b=>p(b,HTMLElement).hidden=i),p("headset",HTMLButtonElement).hidden=o===void 0,p("orbit",HTMLInputElement).disabled=er(e)===0,this.#l.setFilm(e,a?"View":"Frame"),this.#a.setFilm(e,r),p("steps",HTMLSelectElement).disabled=t==="cpu";let c=Number(e.framesPerSecond.toFixed(3)),u=a?`${e.frameCount} views`:`${e.frameCount} frames at ${c}/s`,l=i?"still":u,{length:d}=e.probes,f=d===0?[]:[`${G(d)} ${d===1?"probe":"probes"}`],m=p("film-facts",HTMLElement),h=t==="cpu"?["small pictures, drawn on the processor"]:[];m.title=[...f,l,ie(e.fileBytes),...h].join(" · "),M(m,m.title),M(p("headset-help",HTMLElement),Ci(this.#e.kind,o!==void 0))}#T(){let e=this.#c;e!==void 0&&(this.#b=e.clock.frame(performance.now()),this.#c=void 0,this.#h=void 0,e.player.close())}#U(){this.#w!==void 0&&(this.#n.say(`${_r(this.#w)}; the processor draws small pictures`,Bi),this.#w=void 0)}#S({fatal:e,passes:t,isOfDevice:r=!1,message:n}){if(!e){this.#n.say(n,t===!0?Bi:1/0);return}let o=this.#h?.stats,i=o!==void 0&&(o.unitsMissing===0||o.marchMs>0),a=this.#k&&(i||!r);this.#k=!1,this.#T(),a?(this.#n.say(`${_r(n)}; the film is loaded again`),this.load()):r?this.load(n):(this.#r.replaceChildren(),this.#s.failed(n))}#C(e){requestAnimationFrame(i=>this.#C(i));let t=(e-this.#_)/1e3;this.#_=e;let r=this.#c;if(r===void 0)return;this.#m.advance(t),this.#z(r,t);let n=performance.now(),o=r.clock.frame(n);o!==this.#b&&(this.#b=o,r.loop.move()),this.#d.marks.has("fetched")&&(this.#h?.stats.fetchRate??0)>0&&r.loop.change(),r.loop.tick(),(r.loop.isSettled||!this.#W(r))&&(this.#p?.remove(),this.#p=void 0),this.#r.ariaBusy=String(!r.loop.isSettled),this.#l.showFrame(o,this.#h?.stats.shownFrame??o),p("play",HTMLButtonElement).classList.toggle("playing",r.clock.isPlaying),p("play",HTMLButtonElement).ariaLabel=r.clock.isPlaying?"Pause":"Play",n-this.#E>=zd&&(this.#E=n,this.#V(r)),n-this.#R>=Gd&&r.loop.isStill&&!r.clock.isPlaying&&(this.#R=n,this.#I(o))}#z({player:{film:e},loop:t},r){if(this.#u===void 0||this.#e.kind==="quilt")return;let n=this.#f.advance(this.#u,{film:e,seconds:r,isShown:t.isSettled,isFluent:t.isFluent});n!==void 0&&(this.#u={...this.#u,eye:se(n,e.headBox)},t.move()),p("orbit",HTMLInputElement).checked=this.#f.isOn}#W({player:{film:e},clock:t}){let{eye:r,yaw:n,pitch:o}=this.#O(e),i=this.#u??ir;return i.yaw===n&&i.pitch===o&&i.eye.join()===se(r,e.headBox).join()&&!t.isPlaying&&this.#b===nn(e)}#j(e){Oi(e,Ni(this.#e.name,this.#b??0)).catch(r=>this.#n.say(ae(r)))}#V(e){this.#l.showFetched(e.player.fetched());let t=this.#h?.stats.unitsMissing??0,r=p("state",HTMLElement),n=performance.now();if(this.#M=t===0?n:this.#M,r.hidden=this.#h!==void 0&&n-this.#M<$d,M(r,this.#h?`${G(t)} tiles and cells not loaded yet`:"Loading the first picture"),this.#h!==void 0&&this.#u!==void 0&&this.#o.open==="inspector"){let[o,i]=this.#L(1),a=Math.tan(this.#d.fovDeg*Math.PI/360)*(o/i),c=2*Math.atan(a)*180/Math.PI;this.#a.show({...this.#h,pose:this.#u,fovDeg:c,command:this.#K(this.#u)})}}#$(e){let{marks:t,fovDeg:r,stereo:n,eyeDistance:o,exposureEv:i,toneMap:a,steps:c}=this.#d,u=new Set((this.#c?.marks??[]).flatMap(h=>h!=="overdraw"&&t.has(h)?[h]:[])),[l,d,f]=[this.#u??ir,this.#b??0,this.#L(e,this.#c?.player.mostPixels)],m=this.#c?.clock.isPlaying??!1;return{pose:l,frame:d,playing:m,size:f,fovDeg:r,stereo:n,eyeDistance:o,exposureEv:i,toneMap:a,overlays:u,steps:c}}#L(e,t=1/0){let[r,n]=[this.#r.clientWidth,this.#r.clientHeight],o=window.devicePixelRatio*this.#d.scale,i=e*Math.min(o,Wd/Math.max(r,n,1),Math.sqrt(t/(r*n)));return[Math.max(2,2*Math.round(r*i/2)),Math.max(1,Math.round(n*i))]}#K(e){let{kind:t,name:r}=this.#e;if(t==="quilt")return;let{fovDeg:n,stereo:o,eyeDistance:i}=this.#d,a={pose:e,fovDeg:n,stereo:o,eyeDistance:i,size:this.#L(1/this.#d.scale)};return _i(r,t==="glb"?a:{...a,frame:this.#b??0})}#D(){let e=this.#c?.player.film.headBox,t=e===void 0?[0]:e.least.map((r,n)=>e.greatest[n]-r);return Math.min(Math.max(jd*Math.max(...t),Ii[0]),Ii[1])}#q(e,t){this.#u===void 0||this.#c===void 0||this.#e.kind==="quilt"||(this.#f.stop(),this.#u=pn(this.#u,e,t),this.#c.loop.move())}#X(e){if(this.#u===void 0||this.#c===void 0||this.#e.kind==="quilt")return;this.#f.stop();let t=hi(this.#u.eye,bn(this.#u,e),this.#c.player.film.headBox);this.#u={...this.#u,eye:t},this.#c.loop.move()}#Y(e){let t=this.#c;if(this.#e.kind==="quilt"&&t!==void 0&&!t.clock.isPlaying){let{firstFrame:r,frameCount:n}=t.player.film;t.clock.seek(r+e*(n-1),performance.now())}}#N(e){this.#c?.clock.pause(performance.now()),this.#c?.clock.seek(e,performance.now())}#v(e){let t={...this.#d,...e};this.#d=t,this.#i.show(t),this.#a.showMarks(t.marks),this.#E=-1/0;let r=this.#c;r!==void 0&&(r.clock.isLooped=t.isLooped,r.clock.setSpeed(t.speed,performance.now()),r.showOverdraw?.(t.marks.has("overdraw")),r.loop.move()),this.#e.kind==="lfold"&&t.renderer!==this.#x&&this.load()}#J(e,t){let r=[...this.#d.marks].filter(n=>n!==e);this.#v({marks:new Set(t?[...r,e]:r)})}#O(e){return this.#e.start?.pose??e.start}#H(e){let{start:t}=this.#e,r=t===void 0||$t(e)?U.fovDeg:t.fovDeg;return{...U,fovDeg:r,...e.settings}}#G(e,{eye:t,look:r}){let n=this.#c?.player.film.headBox;return{eye:t!==void 0&&n!==void 0?se(t,n):e.eye,yaw:r?.[0]??e.yaw,pitch:r?.[1]??e.pitch}}#Q(){let e=Kt(location.hash),t=this.#c;this.#f.stop(),this.#u=t&&this.#G(this.#O(t.player.film),e),this.#b=void 0,t!==void 0&&this.#N(e.frame??nn(t.player.film)),this.#v(this.#H(e)),this.#c?.loop.move()}#I(e){let t=gi(this.#u??ir,e,this.#d);t!==location.hash&&history.replaceState(null,"",t)}#B(e){let[t,r]=[this.#c,performance.now()];t!==void 0&&(e==="settings"||e==="inspector"||e==="help"?this.#o.toggle(e):e==="full-screen"?Kd().catch(()=>this.#n.say("The browser allows no full screen here.")):this.#Z(t,e,r))}#Z({clock:e,player:t,loop:r},n,o){let{film:i}=t;switch(n){case"play":return r.change(),e.isPlaying?e.pause(o):e.play(o);case"step-back":return e.step(-1,o);case"step-forward":return e.step(1,o);case"first":return this.#N(i.firstFrame);case"last":return this.#N(e.lastFrame);case"loop":return this.#v({isLooped:!this.#d.isLooped});case"slower":return this.#v({speed:De.findLast(a=>a<this.#d.speed)??De[0]});case"faster":return this.#v({speed:De.find(a=>a>this.#d.speed)??De[De.length-1]});case"reset":return this.#u=this.#O(i),r.move();case"lock-pointer":return this.#m.toggleLock();case"screenshot":return this.#y=!0,r.change()}}#ee(){["play","step-back","step-forward","first","last","loop","screenshot","full-screen"].forEach(n=>H(n,()=>this.#B(n)));for(let n of["settings","inspector","help"])H(`open-${n}`,()=>this.#B(n));let t=H("copy-link",()=>{this.#c!==void 0&&this.#I(this.#b??0),Ye(location.href,t)}),r=p("orbit",HTMLInputElement);r.addEventListener("change",()=>r.checked?this.#f.ask():this.#f.stop()),H("headset",()=>{this.#c?.enterHeadset?.(this.#u??ir)?.catch(o=>this.#n.say(`The headset does not open: ${ae(o)}`))})}};function nn({startFrame:s,firstFrame:e}){return s??e}var ir={eye:[0,0,0],yaw:0,pitch:0};async function Kd(){await(document.fullscreenElement===null?document.documentElement.requestFullscreen():document.exitFullscreen())}async function qd(){try{let s=new URL("film.json",document.baseURI);await new ar(await kn(s.href),fi).load()}catch(s){new ce(()=>location.reload()).failed(s)}}qd();
