"""What every page has: its style, and the script that turns the rig."""

from __future__ import annotations

from .plots._style import DARK, LIGHT


def _variables(colours: dict[str, str]) -> str:
    return "".join(f"--{name}:{colour};" for name, colour in colours.items())


STYLE = (
    ":root{color-scheme:light dark;" + _variables(LIGHT) + "--good:#00794f;--warn:#9a6200}"
    "@media (prefers-color-scheme:dark){:root{"
    + _variables(DARK) + "--good:#35cfa2;--warn:#f2b233}}"
    """
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);
 font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
main{max-width:64rem;margin:0 auto;padding:1.5rem 1rem 3rem}
h1{font-size:1.5rem;line-height:1.25;margin:0 0 .8rem;overflow-wrap:anywhere}
h2{font-size:1.1rem;margin:2.2rem 0 .5rem}
p,ol,ul{margin:.5rem 0}
.verdict{border-left:.35rem solid var(--mark);background:var(--panel);padding:.8rem 1rem}
.verdict b{color:var(--mark);display:block}
.verdict .main{font-size:1.15rem;font-weight:600;margin:0}
.good{--mark:var(--good)}.warn{--mark:var(--warn)}.bad-one{--mark:var(--bad)}
.none{--mark:var(--faint)}
.facts{color:var(--faint);margin:.8rem 0}
.wide{overflow-x:auto}
.picture svg{display:block;width:100%;min-width:38rem;height:auto}
.note,figcaption,footer{color:var(--faint);font-size:.87rem}
table{border-collapse:collapse;font-size:.87rem;font-variant-numeric:tabular-nums}
th,td{text-align:right;padding:.28rem .45rem;border-bottom:1px solid var(--line);
 vertical-align:top;white-space:nowrap}
th{color:var(--faint);font-weight:600}
.text,.long,th:first-child,td:first-child{text-align:left}
td:first-child{font-weight:600}td.long{white-space:normal;min-width:14rem;max-width:28rem}
i.dot{display:inline-block;width:.65em;height:.65em;border-radius:50%;margin-right:.45em}
.thumbs{display:grid;grid-template-columns:repeat(auto-fill,minmax(17rem,1fr));gap:1rem}
figure{margin:0}.thumbs svg{display:block;width:100%;height:auto}
#space{position:relative}
#space canvas{display:none;width:100%;touch-action:pan-y;cursor:grab}
#space.live canvas{display:block}#space.live .still{display:none}
pre{overflow-x:auto;font-size:.78rem;line-height:1.35;background:var(--panel);padding:.8rem}
summary{cursor:pointer}footer{margin-top:2.5rem}
@media print{#space.live canvas{display:none}#space.live .still{display:block}}
"""
)  # fmt: skip

# The rig as lines in the box -1..1, z up: x to the right, y up on the screen, w to the eye.
SCRIPT = """
(function(){
var data=JSON.parse(document.getElementById("lines").textContent),
 box=document.getElementById("space"),canvas=document.createElement("canvas"),
 g=canvas.getContext("2d"),azim=-1.08,elev=0.38,zoom=1,held=null;
if(!g)return;
function place(p,o){
 var ca=Math.cos(azim),sa=Math.sin(azim),ce=Math.cos(elev),se=Math.sin(elev),
  x=-sa*p[o]+ca*p[o+1],y=-se*ca*p[o]-se*sa*p[o+1]+ce*p[o+2],
  w=ce*ca*p[o]+ce*sa*p[o+1]+se*p[o+2],s=unit*zoom*4/(4-w);
 return[canvas.width/2+s*x+zoom*shift[0],canvas.height/2-s*y+zoom*shift[1]];
}
var unit=1,shift=[0,0];
function fit(){
 var low=[1e9,1e9],high=[-1e9,-1e9],old=[azim,elev,zoom],i,k,at;
 azim=-1.08;elev=0.38;zoom=unit=1;shift=[0,0];
 data.lines.forEach(function(line){
  if(line[0]!=="line")for(i=0;i<line[2].length;i+=3){at=place(line[2],i);
   for(k=0;k<2;k++){low[k]=Math.min(low[k],at[k]);high[k]=Math.max(high[k],at[k])}}});
 unit=0.84*Math.min(canvas.width/(high[0]-low[0]),canvas.height/(high[1]-low[1]));
 shift=[unit*(canvas.width-low[0]-high[0])/2,unit*(canvas.height-low[1]-high[1])/2];
 azim=old[0];elev=old[1];zoom=old[2];
}
function draw(){
 var ratio=window.devicePixelRatio||1,wide=box.clientWidth,css=getComputedStyle(box);
 canvas.width=wide*ratio;canvas.height=Math.min(wide*0.66,560)*ratio;
 fit();
 function ink(name){return css.getPropertyValue("--"+name)}
 g.lineJoin="round";
 data.lines.forEach(function(line){
  var p=line[2],at;
  g.strokeStyle=ink(line[0]);g.lineWidth=line[1]*ratio;g.beginPath();
  for(var i=0;i<p.length;i+=3){at=place(p,i);
   if(i)g.lineTo(at[0],at[1]);else g.moveTo(at[0],at[1]);}
  g.stroke();});
 g.textAlign="center";g.font="600 "+13*ratio+"px system-ui,sans-serif";
 data.names.forEach(function(n){
  var at=place(n[1],0);g.lineWidth=4*ratio;g.strokeStyle=ink("paper");
  g.strokeText(n[0],at[0],at[1]-5*ratio);
  g.fillStyle=ink("ink");g.fillText(n[0],at[0],at[1]-5*ratio);});
}
function turn(dx,dy){azim-=dx;elev=Math.max(-1.5,Math.min(1.5,elev+dy));draw()}
canvas.tabIndex=0;canvas.setAttribute("role","img");
canvas.setAttribute("aria-label",data.label);
canvas.addEventListener("pointerdown",function(e){held=[e.clientX,e.clientY];
 canvas.setPointerCapture(e.pointerId)});
canvas.addEventListener("pointermove",function(e){if(!held)return;
 turn((e.clientX-held[0])*0.008,(e.clientY-held[1])*0.008);held=[e.clientX,e.clientY]});
["pointerup","pointercancel"].forEach(function(name){
 canvas.addEventListener(name,function(){held=null})});
canvas.addEventListener("keydown",function(e){
 var step={ArrowLeft:[0.1,0],ArrowRight:[-0.1,0],ArrowUp:[0,0.1],ArrowDown:[0,-0.1]}[e.key];
 if(e.key==="+"||e.key==="-"){zoom*=e.key==="+"?1.15:1/1.15;draw()}
 else if(step){turn(step[0],step[1])}else return;
 e.preventDefault()});
box.appendChild(canvas);box.classList.add("live");draw();
window.addEventListener("resize",draw);
matchMedia("(prefers-color-scheme:dark)").addEventListener("change",draw);
})();
"""
